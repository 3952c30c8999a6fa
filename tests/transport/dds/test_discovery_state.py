"""The graph out of what DDS and ros_discovery_info tell."""

from __future__ import annotations

import pytest
from helpers.captured import Captured
from hypothesis import given
from hypothesis import strategies as st

from goalwire.errors import RemoteError
from goalwire.rules.qos import DEFAULT
from goalwire.transport.contract import EndpointKind, GraphEntity
from goalwire.transport.dds.description import Role
from goalwire.transport.dds.discovery_state import (
    OLD_GID_SIZE,
    UNKNOWN_NAME,
    DiscoveryState,
    Found,
    NodeInfo,
    ParticipantInfo,
    decode_info,
    encode_info,
)
from goalwire.transport.graph_dispatcher import Change

PEER = bytes([1]) * 16


def gid(number: int) -> bytes:
    return bytes([number]) * 16


def found(number: int, role: Role = Role.TOPIC, *, is_reader: bool = False) -> Found:
    return Found(gid(number), PEER, role, is_reader, '/chatter', 'std_msgs/msg/String', '', DEFAULT)


def info(*nodes: NodeInfo) -> ParticipantInfo:
    return ParticipantInfo(PEER, nodes)


def node(name: str, *writers: int) -> NodeInfo:
    return NodeInfo('/', name, (), tuple(gid(number) for number in writers))


def met(speaks_ros: bool = True) -> DiscoveryState:
    discovered = DiscoveryState()
    discovered.participant_came(PEER, '/')
    if speaks_ros:
        discovered.ros_speaker_came(PEER)
    return discovered


def said(changes: list[Change]) -> list[str]:
    """Return changes as text: '+talker', '+talker/chatter', '-talker'."""

    def text(entity: GraphEntity) -> str:
        name = entity.node.name
        return name if entity.kind is EndpointKind.NODE else f'{name}{entity.name}'

    return [f'{"+" if is_there else "-"}{text(entity)}' for is_there, entity in changes]


def test_an_endpoint_is_shown_when_its_node_is_told() -> None:
    discovered = met()
    assert discovered.endpoint_came(found(5)) == []
    assert said(discovered.learn(info(node('talker', 5)))) == ['+talker', '+talker/chatter']


def test_a_node_may_be_told_before_its_endpoints_are_found() -> None:
    discovered = met()
    assert said(discovered.learn(info(node('talker', 5)))) == ['+talker']
    assert said(discovered.endpoint_came(found(5))) == ['+talker/chatter']


def test_the_same_telling_twice_changes_nothing() -> None:
    discovered = met()
    discovered.learn(info(node('talker', 5)))
    discovered.endpoint_came(found(5))
    assert discovered.learn(info(node('talker', 5))) == []
    assert discovered.endpoint_came(found(5)) == []


def test_each_end_of_a_topic_or_service_has_its_kind_and_replies_have_none() -> None:
    discovered = met(speaks_ros=False)
    ends = [(role, is_reader) for role in Role for is_reader in (False, True)]
    kinds = [
        entity.kind
        for number, (role, is_reader) in enumerate(ends, 10)
        for _, entity in discovered.endpoint_came(found(number, role, is_reader=is_reader))
    ]
    assert kinds == [
        EndpointKind.PUBLISHER,
        EndpointKind.SUBSCRIPTION,
        EndpointKind.CLIENT,
        EndpointKind.SERVICE,
    ]


def test_an_endpoint_that_goes_is_hidden_once() -> None:
    discovered = met()
    discovered.learn(info(node('talker', 5)))
    discovered.endpoint_came(found(5))
    assert said(discovered.endpoint_went(gid(5))) == ['-talker/chatter']
    assert discovered.endpoint_went(gid(5)) == []


def test_a_node_that_is_told_no_more_is_gone_and_its_endpoints_hidden() -> None:
    discovered = met()
    discovered.learn(info(node('talker', 5), node('other')))
    discovered.endpoint_came(found(5))
    assert said(discovered.learn(info(node('other')))) == ['-talker/chatter', '-talker']
    assert discovered.unclaimed == {gid(5)}


def test_a_participant_goes_with_all_it_had() -> None:
    discovered = met()
    discovered.learn(info(node('talker', 5, 6)))
    discovered.endpoint_came(found(5))
    assert sorted(said(discovered.participant_went(PEER))) == ['-talker', '-talker/chatter']
    assert discovered.participant_went(PEER) == []
    assert discovered.endpoint_went(gid(5)) == []


def test_what_a_departed_participant_had_told_brings_it_not_back() -> None:
    discovered = met()
    discovered.participant_went(PEER)
    assert discovered.learn(info(node('talker'))) == []
    assert discovered.endpoint_came(found(5)) == []


def test_an_endpoint_that_no_node_claims_is_nobodys_after_a_while() -> None:
    discovered = met()
    discovered.endpoint_came(found(5))
    assert said(discovered.show_unclaimed({gid(5)})) == [f'+{UNKNOWN_NAME}/chatter']
    assert discovered.unclaimed == set()
    assert said(discovered.learn(info(node('talker', 5)))) == [
        '+talker',
        f'-{UNKNOWN_NAME}/chatter',
        '+talker/chatter',
    ]


def test_the_end_of_an_endpoint_that_was_never_claimed_is_told() -> None:
    discovered = met()
    discovered.endpoint_came(found(5))
    unknown = f'{UNKNOWN_NAME}/chatter'
    assert said(discovered.endpoint_went(gid(5))) == [f'+{unknown}', f'-{unknown}']
    assert discovered.show_unclaimed([gid(5)]) == []


def test_the_endpoints_of_a_participant_that_goes_before_it_told_its_nodes_are_told_to_go() -> None:
    discovered = met()
    discovered.endpoint_came(found(5))
    unknown = f'{UNKNOWN_NAME}/chatter'
    assert said(discovered.participant_went(PEER)) == [f'+{unknown}', f'-{unknown}']
    assert not discovered.unclaimed


def test_what_was_claimed_in_time_is_not_given_up() -> None:
    discovered = met()
    discovered.endpoint_came(found(5))
    discovered.learn(info(node('talker', 5)))
    assert discovered.show_unclaimed({gid(5)}) == []


def test_an_endpoint_of_a_participant_without_ros_2_is_nobodys_at_once() -> None:
    discovered = met(speaks_ros=False)
    assert said(discovered.endpoint_came(found(5))) == [f'+{UNKNOWN_NAME}/chatter']


def test_twins_are_recognised_by_their_endpoints() -> None:
    discovered = met()
    changes = discovered.learn(info(node('twin', 5), node('twin', 6)))
    first, second = (entity.node_id for _, entity in changes)
    assert first != second
    discovered.endpoint_came(found(6))
    ((is_there, gone),) = discovered.learn(info(node('twin', 6)))
    assert (is_there, gone.node_id) == (False, first)


def test_an_endpoint_may_move_to_another_node() -> None:
    discovered = met()
    discovered.learn(info(node('one', 5), node('two')))
    discovered.endpoint_came(found(5))
    assert said(discovered.learn(info(node('one'), node('two', 5)))) == ['-one/chatter', '+two/chatter']


GID = bytes(range(1, 17))
NODES = (
    NodeInfo('/', 'alpha', (bytes([1]) * 16, bytes([2]) * 16), (bytes([3]) * 16,)),
    NodeInfo('/fleet/robot_1', 'b'),
)


def test_a_real_nodes_message_is_read_and_written_byte_for_byte(captured: list[Captured]) -> None:
    (message,) = [each for each in captured if each.topic == 'ros_discovery_info']
    info = decode_info(message.payload)
    (node,) = info.nodes
    assert (node.namespace, node.name) == ('/', 'real_cli')
    assert (len(node.readers), len(node.writers)) == (8, 9)
    assert info.gid.hex() == '0110818782581a1870b48788000001c1'
    assert encode_info(info) == message.payload


@pytest.mark.parametrize('size', [16, OLD_GID_SIZE])
@pytest.mark.parametrize('nodes', [(), NODES])
def test_both_forms_are_told_apart(size: int, nodes: tuple[NodeInfo, ...]) -> None:
    info = ParticipantInfo(GID, nodes)
    assert decode_info(encode_info(info, size)) == info


@pytest.mark.parametrize('size', [16, OLD_GID_SIZE])
def test_a_message_that_is_cut_short_is_refused(size: int) -> None:
    whole = encode_info(ParticipantInfo(GID, NODES), size)
    empty = set(range(24, 28))  # what ends here is a whole message of the newer form, without nodes
    for length in set(range(len(whole) - 1)) - empty:
        with pytest.raises(RemoteError, match='ros_discovery_info'):
            decode_info(whole[:length])


@given(st.binary(max_size=200))
def test_any_bytes_are_read_or_refused(raw: bytes) -> None:
    try:
        decode_info(b'\0\1\0\0' + raw)
    except RemoteError as error:
        assert 'ros_discovery_info' in str(error)  # noqa: PT017 - either way is right


def test_counts_beyond_the_message_are_refused_before_anything_is_made_of_them() -> None:
    with pytest.raises(RemoteError, match='4294967295 items do not fit'):
        decode_info(b'\0\1\0\0' + GID + b'\xff' * 4)
