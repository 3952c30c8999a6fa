"""Keys, QoS and liveliness tokens."""

from __future__ import annotations

import pytest
import xxhash
from hypothesis import given
from hypothesis import strategies as st

from goalwire.errors import LocalError, RemoteError, TransportError
from goalwire.rules.qos import (
    INFINITE_NS,
    PARAMETERS,
    ROSOUT,
    SENSOR_DATA,
    DurabilityPolicy,
    HistoryPolicy,
    LivelinessPolicy,
    QoS,
    ReliabilityPolicy,
)
from goalwire.transport.contract import Endpoint, EndpointKind, NodeName
from goalwire.transport.zenoh.ros_keys import (
    data_key,
    dds_type,
    decode_qos,
    encode_endpoint,
    encode_node,
    encode_qos,
    gid_of,
    graph_key,
    own_entity,
    parse,
    ros_type,
)

STRING_HASH = 'RIHS01_df668c740482bbd48fb39d76a70dfd4bd59db1288021743503259e948f6b1a18'
ADD_HASH = 'RIHS01_e118de6bf5eeb66a2491b5bda11202e7b68f198d6f67922cf30364858239c81a'


@pytest.mark.parametrize(
    ('domain', 'name', 'type_name', 'type_hash', 'key'),
    [
        (
            0,
            '/chatter',
            'std_msgs/msg/String',
            STRING_HASH,
            f'0/chatter/std_msgs::msg::dds_::String_/{STRING_HASH}',
        ),
        (
            0,
            '/robot1/chatter',
            'std_msgs/msg/String',
            STRING_HASH,
            f'0/robot1/chatter/std_msgs::msg::dds_::String_/{STRING_HASH}',
        ),
        (
            2,
            '/add_two_ints',
            'example_interfaces/srv/AddTwoInts',
            ADD_HASH,
            f'2/add_two_ints/example_interfaces::srv::dds_::AddTwoInts_/{ADD_HASH}',
        ),
        (
            0,
            '/fib/_action/send_goal',
            'pkg/action/Fib_SendGoal',
            'RIHS01_1',
            '0/fib/_action/send_goal/pkg::action::dds_::Fib_SendGoal_/RIHS01_1',
        ),
    ],
)
def test_a_key_is_domain_name_type_and_hash(
    domain: int, name: str, type_name: str, type_hash: str, key: str
) -> None:
    assert data_key(domain, name, type_name, type_hash) == key


def test_one_slash_at_either_end_of_a_name_is_dropped() -> None:
    assert data_key(0, '/a/b/', 'p/msg/T', 'h').startswith('0/a/b/p::msg')


@pytest.mark.parametrize('name', ['//a', '/a//b', '/a*', '/a#', '/a?', '/$a', '/a b', ''])
def test_a_name_that_zenoh_cannot_carry_is_refused_by_name(name: str) -> None:
    with pytest.raises(TransportError, match='cannot travel over Zenoh') as caught:
        data_key(0, name, 'p/msg/T', 'h')
    assert repr(name) in str(caught.value)


@pytest.mark.parametrize('type_name', ['std_msgs/msg/String', 'pkg/srv/Add', 'pkg/action/Fib_GetResult'])
def test_a_type_survives_its_dds_spelling(type_name: str) -> None:
    assert ros_type(dds_type(type_name)) == type_name


@pytest.mark.parametrize('spelling', ['String', 'std_msgs::msg::String_', 'std_msgs::msg::dds_::String'])
def test_a_spelling_that_is_not_dds_is_shown_as_it_is(spelling: str) -> None:
    assert ros_type(spelling) == spelling


def test_the_graph_of_a_domain_is_one_expression() -> None:
    assert graph_key(7) == '@ros2_lv/7/**'


DURATIONS = st.integers(1, INFINITE_NS)


@pytest.mark.parametrize(
    ('qos', 'text'),
    [
        (QoS(), '::,10:,:,:,,'),
        (QoS(depth=42), '::,:,:,:,,'),
        (QoS(depth=0), '::,:,:,:,,'),
        (SENSOR_DATA, '2::,5:,:,:,,'),
        (QoS(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL), ':1:,1:,:,:,,'),
        (QoS(depth=0, history=HistoryPolicy.KEEP_ALL), '::2,:,:,:,,'),
        (PARAMETERS, '::,1000:,:,:,,'),
        (ROSOUT, ':1:,1000:,:10,0:,,'),
        (QoS(depth=5, deadline_ns=1_500_000_000), '::,5:1,500000000:,:,,'),
        (QoS(depth=5, liveliness=LivelinessPolicy.MANUAL_BY_TOPIC, lease_ns=2), '::,5:,:,:3,0,2'),
        (QoS(depth=5, reliability=ReliabilityPolicy.BEST_AVAILABLE), '4::,5:,:,:,,'),
    ],
)
def test_only_what_differs_from_rmws_defaults_is_written(qos: QoS, text: str) -> None:
    assert encode_qos(qos) == text


@pytest.mark.parametrize(
    'qos',
    [
        QoS(reliability=ReliabilityPolicy.SYSTEM_DEFAULT),
        QoS(durability=DurabilityPolicy.SYSTEM_DEFAULT),
        QoS(history=HistoryPolicy.SYSTEM_DEFAULT),
        QoS(deadline_ns=INFINITE_NS, lifespan_ns=INFINITE_NS, lease_ns=INFINITE_NS),
        QoS(liveliness=LivelinessPolicy.AUTOMATIC),
    ],
)
def test_a_system_default_is_written_like_the_default(qos: QoS) -> None:
    assert encode_qos(qos) == encode_qos(QoS())


@pytest.mark.parametrize(
    'qos',
    [
        QoS(reliability=ReliabilityPolicy.UNKNOWN),
        QoS(durability=DurabilityPolicy.UNKNOWN),
        QoS(history=HistoryPolicy.UNKNOWN),
        QoS(liveliness=LivelinessPolicy.UNKNOWN),
    ],
)
def test_an_unknown_policy_cannot_be_declared(qos: QoS) -> None:
    with pytest.raises(LocalError, match='UNKNOWN'):
        encode_qos(qos)


def test_half_of_an_infinite_duration_stays_empty() -> None:
    """Seconds and nanoseconds are compared one by one."""
    assert encode_qos(QoS(depth=42, deadline_ns=9_223_372_036_000_000_001)) == '::,:,1:,:,,'


@given(
    st.builds(
        QoS,
        depth=st.integers(1, 10_000),
        history=st.sampled_from([HistoryPolicy.KEEP_LAST, HistoryPolicy.KEEP_ALL]),
        reliability=st.sampled_from([ReliabilityPolicy.RELIABLE, ReliabilityPolicy.BEST_EFFORT]),
        durability=st.sampled_from([DurabilityPolicy.VOLATILE, DurabilityPolicy.TRANSIENT_LOCAL]),
        deadline_ns=DURATIONS,
        lifespan_ns=DURATIONS,
        liveliness=st.sampled_from([LivelinessPolicy.AUTOMATIC, LivelinessPolicy.MANUAL_BY_TOPIC]),
        lease_ns=DURATIONS,
    )
)
def test_what_is_written_is_read(qos: QoS) -> None:
    assert decode_qos(encode_qos(qos)) == qos


@pytest.mark.parametrize(
    'text',
    ['', '::', '::,:,:,:,', 'x::,:,:,:,,', '9::,:,:,:,,', '::,-1:,:,:,,', '::,:,,:,:,,', '::,²:,:,:,,'],
)
def test_text_that_breaks_the_grammar_is_the_peers_fault(text: str) -> None:
    with pytest.raises(RemoteError):
        decode_qos(text)


ZID = 'f00dbabe0123456789abcdef01234567'
HASH = f'RIHS01_{"a1" * 32}'
NODE = NodeName('talker')
NODE_TOKEN = f'@ros2_lv/0/{ZID}/0/0/NN/%/%/talker'
TOPIC = f'%robot1%chatter/std_msgs::msg::dds_::String_/{HASH}'
TOPIC_TOKEN = f'@ros2_lv/0/{ZID}/0/1/MP/%/%robot1/talker/{TOPIC}/::,10:,:,:,,'


def endpoint(kind: EndpointKind, *, has_buffers: bool = False, qos: QoS | None = None) -> Endpoint:
    return Endpoint(
        kind, '/robot1/chatter', 'std_msgs/msg/String', HASH, qos or QoS(), has_buffers=has_buffers
    )


def token_of(declared: Endpoint) -> str:
    return encode_endpoint(0, ZID, 0, 1, NodeName('talker', '/robot1'), declared)


def test_a_node_shows_itself_in_nine_chunks() -> None:
    assert encode_node(0, ZID, 0, NODE) == NODE_TOKEN


def test_an_endpoint_shows_itself_in_thirteen() -> None:
    assert token_of(endpoint(EndpointKind.PUBLISHER)) == TOPIC_TOKEN


@pytest.mark.parametrize(
    ('kind', 'code'),
    [
        (EndpointKind.PUBLISHER, 'MP'),
        (EndpointKind.SUBSCRIPTION, 'MS'),
        (EndpointKind.SERVICE, 'SS'),
        (EndpointKind.CLIENT, 'SC'),
    ],
)
def test_every_kind_has_its_code(kind: EndpointKind, code: str) -> None:
    assert token_of(endpoint(kind)) == TOPIC_TOKEN.replace('/MP/', f'/{code}/')


def test_a_subscription_to_buffers_says_it_takes_plain_memory() -> None:
    subscription = endpoint(EndpointKind.SUBSCRIPTION, has_buffers=True)
    assert token_of(subscription) == TOPIC_TOKEN.replace('/MP/', '/MS/') + '/backends:cpu:'


def test_a_lasting_subscription_to_buffers_says_nothing_of_memory() -> None:
    lasting = QoS(durability=DurabilityPolicy.TRANSIENT_LOCAL)
    subscription = endpoint(EndpointKind.SUBSCRIPTION, has_buffers=True, qos=lasting)
    assert 'backends' not in token_of(subscription)


def test_a_publisher_of_buffers_says_nothing_of_memory() -> None:
    assert token_of(endpoint(EndpointKind.PUBLISHER, has_buffers=True)) == TOPIC_TOKEN


def test_a_token_says_who_it_is() -> None:
    entity = parse(TOPIC_TOKEN)
    assert (entity.kind, entity.session, entity.node_id) == (EndpointKind.PUBLISHER, ZID, 0)
    assert entity.node == NodeName('talker', '/robot1')
    assert (entity.name, entity.type_name) == ('/robot1/chatter', 'std_msgs/msg/String')
    assert (entity.type_hash, entity.qos.depth) == (HASH, 10)
    assert entity.gid == gid_of(TOPIC_TOKEN)


def test_a_fourteenth_chunk_is_accepted() -> None:
    assert parse(f'{TOPIC_TOKEN}/backends:cpu:;cuda:0').name == '/robot1/chatter'


def test_humbles_missing_hash_is_accepted() -> None:
    assert parse(TOPIC_TOKEN.replace(HASH, 'TypeHashNotSupported')).type_hash == 'TypeHashNotSupported'


@given(
    st.text('abcXYZ_09', min_size=1),
    st.lists(st.text('abc_', min_size=1), max_size=3),
    st.integers(0, 2**31),
)
def test_any_node_is_read_back(name: str, namespace: list[str], number: int) -> None:
    node = NodeName(name, '/' + '/'.join(namespace))
    entity = parse(encode_node(3, ZID, number, node))
    assert (entity.node, entity.node_id, entity.session) == (node, number, ZID)


@pytest.mark.parametrize(
    'token',
    [
        '',
        'chatter',
        NODE_TOKEN.replace('@ros2_lv', '@other'),
        NODE_TOKEN.rsplit('/', 1)[0],
        NODE_TOKEN.replace('/NN/', '/XX/'),
        NODE_TOKEN.replace('/NN/', '/MP/'),
        NODE_TOKEN.replace('/0/0/', '/0//'),
        NODE_TOKEN.replace('/0/0/', '/x/0/'),
        NODE_TOKEN.replace('@ros2_lv/0', '@ros2_lv/-1'),
        NODE_TOKEN.replace('/0/0/', f'/{"9" * 21}/0/'),
        NODE_TOKEN.replace('/0/0/', f'/0/{"9" * 5000}/'),
        TOPIC_TOKEN.replace(',10:', f',{"9" * 21}:'),
        TOPIC_TOKEN.rsplit('/', 1)[0],
        TOPIC_TOKEN.replace('::,10:,:,:,,', 'nonsense'),
    ],
)
def test_a_token_that_breaks_the_grammar_is_the_peers_fault(token: str) -> None:
    with pytest.raises(RemoteError, match='token'):
        parse(token)


@given(st.text(max_size=80))
def test_no_text_does_any_harm(text: str) -> None:
    for token in (text, f'@ros2_lv/{text}', f'{NODE_TOKEN}/{text}', f'{TOPIC_TOKEN[:-5]}{text}'):
        try:
            entity = parse(token)
        except RemoteError:
            continue
        assert entity.node.name


@pytest.mark.parametrize('name', ['', 'a*', 'a#b'])
def test_a_node_name_that_zenoh_cannot_carry_is_refused(name: str) -> None:
    with pytest.raises(TransportError, match='cannot carry'):
        encode_node(0, ZID, 0, NodeName(name))


def test_a_gid_is_the_hash_of_the_token_low_half_first() -> None:
    """XXH3-128 of nothing is known to be 99aa06d3014798d86001c324468d497f, written high half first."""
    assert gid_of('') == bytes.fromhex('99aa06d3014798d86001c324468d497f')[::-1]


def test_every_token_has_its_own_gid() -> None:
    tokens = (NODE_TOKEN, TOPIC_TOKEN, TOPIC_TOKEN.replace('/MP/', '/MS/'))
    assert len({gid_of(token) for token in tokens}) == 3


@pytest.mark.parametrize('topic', ['%chatter', '%a%backends:', '%backends'])
def test_the_gid_of_a_subscription_to_buffers_is_that_of_the_token_as_jazzy_reads_it(topic: str) -> None:
    token = TOPIC_TOKEN.replace('/MP/', '/MS/').replace('%robot1%chatter', topic)
    assert gid_of(f'{token}/backends:cpu:') == gid_of(token) == parse(f'{token}/backends:cpu:').gid
    assert parse(token).gid == xxhash.xxh3_128(token.encode()).intdigest().to_bytes(16, 'little')


@pytest.mark.parametrize('kind', [kind for kind in EndpointKind if kind is not EndpointKind.NODE])
@pytest.mark.parametrize(
    'qos',
    [QoS(), QoS(depth=0), QoS(depth=7, reliability=ReliabilityPolicy.SYSTEM_DEFAULT, lifespan_ns=10**10)],
)
def test_what_we_know_of_our_own_endpoints_is_what_their_tokens_say(kind: EndpointKind, qos: QoS) -> None:
    node = NodeName('talker', '/a/b', '/c')
    ours = Endpoint(kind, '/a/chatter', 'std_msgs/msg/String', 'RIHS01_00', qos)
    token = encode_endpoint(3, 'f00', 1, 2, node, ours)
    assert own_entity(token, 'f00', 1, node, ours) == parse(token)
