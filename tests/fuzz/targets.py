"""Everything that reads what others have written: bytes in, a value or one documented error out.

A target gets any bytes. It returns where they are accepted and raises one of its `errors` where they are not;
anything else that it raises is a find, as is what takes long or much memory. What is accepted must survive
being written and read again, where there is a way to write it.
"""

from __future__ import annotations

import atexit
import shutil
import socket
import ssl
from collections.abc import Callable
from contextlib import suppress
from dataclasses import dataclass
from functools import cache
from itertools import count
from pathlib import Path
from tempfile import NamedTemporaryFile, mkdtemp
from types import SimpleNamespace
from unittest.mock import patch

import trustme
from helpers.rtps_network import Collector, Network, Publisher
from helpers.zenoh_captured import conversation
from helpers.zenoh_protocol import Session as ZenohSession
from helpers.zenoh_protocol import pair

from goalwire.cdr import codec
from goalwire.entities.type_support import action_support, service_support
from goalwire.errors import EncodeValueError, InterfaceError, RemoteError, TransportError
from goalwire.idl import (
    entry_points,
    get_action,
    get_interface,
    get_message,
    get_service,
    register_definitions,
)
from goalwire.idl.grammar import parse_action, parse_message, parse_service
from goalwire.rtps.protocol import bounds
from goalwire.rtps.protocol import wire as rtps_wire
from goalwire.rtps.protocol.messages import HEADER_SIZE
from goalwire.rtps.protocol.participant import Participant
from goalwire.rtps.protocol.qos import RELIABLE, Qos
from goalwire.rules.arguments import ArgumentError, UnknownArguments, parse_arguments
from goalwire.rules.goals import decode_status_array, wire
from goalwire.rules.names.lexer import RuleSyntaxError
from goalwire.rules.parameters.file_syntax import matches, parse_parameter_file
from goalwire.rules.parameters.plain_yaml import read_typed_text
from goalwire.transport.dds import description, discovery_state, service_header
from goalwire.transport.dds.settings.cyclone import read_cyclone
from goalwire.transport.dds.settings.fast_dds import read_fast_dds
from goalwire.transport.zenoh import attachment, ros_keys
from goalwire.transport.zenoh.native_wire import HistoryPublisher
from goalwire.transport.zenoh.settings.json5 import Json5Error
from goalwire.transport.zenoh.settings.native import BeyondOursError, native_settings
from goalwire.transport.zenoh.settings.plan import local_port
from goalwire.transport.zenoh.settings.reader import read_settings
from goalwire.transport.zenoh.settings.values import value_at
from goalwire.zenoh.io.endpoints import TlsFiles, is_quickly_resolved, resolve
from goalwire.zenoh.io.endpoints import parse as parse_address
from goalwire.zenoh.io.tls import TlsStream, client_context, server_context
from goalwire.zenoh.protocol import key_expressions
from goalwire.zenoh.protocol.bodies import Sample as ZenohSample
from goalwire.zenoh.protocol.bodies import del_body, put_body
from goalwire.zenoh.protocol.channels import DATA_CHANNEL, PieceBudget, Reassembly, frame_head
from goalwire.zenoh.protocol.declarations import (
    About,
    Kind,
    When,
    declare,
    declare_expression,
    final,
    interest,
    take_back,
)
from goalwire.zenoh.protocol.link_messages import Role
from goalwire.zenoh.protocol.link_state import Node, tell_of
from goalwire.zenoh.protocol.network import Target as QueryTarget
from goalwire.zenoh.protocol.network import push_head, response_final, wire_key
from goalwire.zenoh.protocol.primitives import encode_timestamp
from goalwire.zenoh.protocol.publication import Publication
from goalwire.zenoh.protocol.querier import Querier

Errors = type[Exception] | tuple[type[Exception], ...]


@dataclass(frozen=True)
class Target:
    """One reader: `seeds` are inputs that it accepts."""

    name: str
    read: Callable[[bytes], object]
    errors: Errors
    seeds: tuple[bytes, ...]

    def __call__(self, data: bytes) -> bool:
        """Return whether the reader accepts the bytes; raise what is neither acceptance nor good refusal."""
        try:
            self.read(data)
        except self.errors as refusal:
            if str(refusal).strip():
                return False
            raise RuntimeError('an error that says nothing') from refusal
        return True


# ---- definitions ----


def text_of(data: bytes) -> str:
    """Return the text of a definition file: its reader refuses what is not UTF-8 before the grammar."""
    return data.decode(errors='replace')


_packages = count()


def build_classes(data: bytes) -> None:
    """Register a message's text, make its class, write and read a message of it."""
    package = f'fuzz{next(_packages)}_msgs'
    register_definitions(package, {'msg/Fuzzed': text_of(data)})
    cls = get_message(f'{package}/msg/Fuzzed')
    message = cls()
    assert repr(message)
    try:
        data = codec.encode(message)
    except EncodeValueError as error:
        if 'of UTF-8, got' in str(error) or 'UTF-16 units, got' in str(error):
            return  # a default is measured in characters, as rosidl does
        raise
    assert codec.decode(data, cls) is not None


def name_a_type(data: bytes) -> None:
    """Ask for a type by any name: no file outside the packages' folders is ever looked at."""
    get_interface(text_of(data))


# ---- messages ----

_CLASSES = (
    get_message('sensor_msgs/msg/PointCloud2'),
    get_message('rcl_interfaces/msg/ParameterEvent'),
    get_message('visualization_msgs/msg/Marker'),
    get_message('trajectory_msgs/msg/JointTrajectory'),
    get_message('type_description_interfaces/msg/TypeDescription'),
    get_message('std_msgs/msg/UInt8MultiArray'),
    service_support(get_service('std_srvs/srv/SetBool')).response,
    action_support(get_action('example_interfaces/action/Fibonacci')).feedback.cls,
)


def read_message(data: bytes) -> None:
    """Read a message of a type that the first byte chooses; what is read is written, and read, the same."""
    cls = _CLASSES[data[0] % len(_CLASSES)] if data else _CLASSES[0]
    message: object = codec.decode(data[1:], cls)
    try:
        again = codec.encode(message)
    except EncodeValueError as error:
        if 'a string cannot contain a NUL' in str(error):
            return  # peers in C++ can send one
        raise
    assert codec.encode(codec.decode(again, cls)) == again  # bytes, since nan does not equal itself


def _messages() -> tuple[bytes, ...]:
    return tuple(bytes([number]) + codec.encode(cls()) for number, cls in enumerate(_CLASSES))


# ---- the wires ----


def read_attachment(data: bytes) -> None:
    """An attachment of either form."""
    read = sequence, stamp, gid = attachment.decode(data)
    assert attachment.decode(attachment.encode(sequence, stamp, attachment.GID_SIZE, gid)) == read


def read_token(data: bytes) -> None:
    """A liveliness token, with the QoS and the type in it."""
    found = ros_keys.parse(text_of(data))
    assert len(found.gid) == attachment.GID_SIZE


def read_qos(data: bytes) -> None:
    """A QoS; it is written in the shortest form, which means the same."""
    qos = ros_keys.decode_qos(text_of(data))
    if 'UNKNOWN' in {qos.reliability.name, qos.durability.name, qos.history.name, qos.liveliness.name}:
        return  # no endpoint of ours has that
    written = ros_keys.encode_qos(qos)
    assert ros_keys.encode_qos(ros_keys.decode_qos(written)) == written


def read_type(data: bytes) -> None:
    """A type's name as tokens and DDS topics spell it."""
    ros_keys.ros_type(text_of(data))


def read_request(data: bytes) -> None:
    """A request or reply over DDS."""
    header, message = service_header.unwrap(data)
    assert service_header.unwrap(service_header.wrap(header, message)) == (header, message)


def read_user_data(data: bytes) -> None:
    """The data that participants and endpoints send about themselves: anything is allowed."""
    description.enclave_of(data)
    description.decode_endpoint(data)


def read_participant(data: bytes) -> None:
    """ros_discovery_info, of either form."""
    info = discovery_state.decode_info(data)
    assert discovery_state.decode_info(discovery_state.encode_info(info)).nodes == info.nodes


def read_goals(data: bytes) -> None:
    """Everything of an action that is read without its type."""
    wire.status_of(data)
    wire.is_acceptance(data)
    wire.unwrap(data)
    wire.decode_cancel_request(data)


# ---- what users write ----


def match_nodes(data: bytes) -> None:
    """A node's name as parameter files write it, and the names of nodes."""
    pattern, *nodes = text_of(data).split('\n')
    for node in nodes:
        matches(pattern, node)


def read_yaml_value(data: bytes) -> None:
    """A value as `ros2 param set` gives it: it is a string if it has no other type."""
    read_typed_text(text_of(data))


def read_entry_points(data: bytes) -> None:
    """The entry points that an installed package registers."""
    entry_points._entries(text_of(data))


def read_command_line(data: bytes) -> None:
    """Arguments, one a line."""
    parse_arguments(['--ros-args', *text_of(data).split('\n')])


_TOKEN = (
    b'@ros2_lv/0/aac3178e146ba6f1fc6e6a4085e77f21/0/10/MP/%/%/talker/%chatter/std_msgs::msg::dds_::String_/'
    b'RIHS01_df668c740482bbd48fb39d76a70dfd4bd59db1288021743503259e948f6b1a18/::,7:,:,:,,'
)
_MESSAGE = b"""# what it is
std_msgs/Header header
string<=20 name "what \\"is\\" it" # [m]
int32[<=3] few [1, -2, 3]
float64[4] all
float64[] some [inf, nan, -1e300]
uint8 KIND=0x1F
string WORD = a word
"""
_PARAMETERS = b"""/**:
  ros__parameters:
    speed: 1.5
    names: [a, b]
/arm/left:
  ros__parameters: {limits: {low: -1, high: 0x10}, on: true, data: [1, 2, 3]}
"""


# ---- Zenoh's protocol ----

_A_SAYS = [batch.sent for batch in conversation() if batch.sender == 'A']
_B_SAYS = [batch.sent for batch in conversation() if batch.sender == 'B']


def shake_hands(data: bytes) -> None:
    """Let a connector and an acceptor hear bytes in the place of the other side's handshake."""
    for connects in (True, False):
        link, _ = ZenohSession(b'\xb1\xb2\xb3\xb4').new_link(connects=connects)
        link.start()
        link.frames.receive(data)


def look_at(sample: ZenohSample) -> None:
    """Look at everything that is read when it is asked for."""
    assert isinstance(sample.timestamp, tuple | None)
    assert isinstance(sample.source_info, tuple | None)


def hear_frames(data: bytes) -> None:
    """Let an open link hear bytes, and everything that a user may look at of what comes."""
    session = ZenohSession(b'\xb1\xb2\xb3\xb4')
    link, wire = session.new_link(connects=True)
    link.start()
    link.frames.receive(b''.join(_A_SAYS[:2]))
    session.declare_subscriber('**', look_at)
    session.declare_queryable('**', lambda query: query.answer(query.key, b''), complete=True)
    session.watch_tokens('@ros2_lv/**', lambda _: None, history=True)
    try:
        link.frames.receive(data)
    finally:
        wire.take()
        session.lose_link(link)
        for failure in session.failures:
            raise failure


def read_key_expression(data: bytes) -> None:
    """Bring an expression into its one form, which must be its own."""
    form = key_expressions.canonical(text_of(data))
    assert key_expressions.canonical(form) == form
    assert key_expressions.includes(form, form)
    key_expressions.intersects(form, 'a/**/b$*c')


def hear_from(role: Role) -> Callable[[bytes], None]:
    """Return what lets an open link to a session of some role hear network messages, rightly numbered."""

    def hear(data: bytes) -> None:
        session, other, cable = pair(Role.PEER, role)
        link, far = cable.links
        session.declare_subscriber('**', look_at)
        session.declare_queryable('a/**', lambda query: query.answer('a/b', b''), complete=True)
        session.watch_tokens('**', lambda _: None, history=True)
        cable.carry()
        head = frame_head(DATA_CHANNEL, far.outgoing._numbers.next[DATA_CHANNEL])
        try:
            link.frames.receive((len(head) + len(data)).to_bytes(2, 'little') + head + data)
        finally:
            assert len(session.gossip.nodes) <= len(data)
            for node in session.to_meet:
                read_addresses('\n'.join(node.locators).encode(errors='replace'))
            session.lose_link(link)
            assert session.tokens('**') == []
            for failure in [*session.failures, *other.failures]:
                raise failure

    return hear


_KEY = wire_key('a/b')
_DECLARED = (
    declare_expression(7, 'a/b') + declare(Kind.SUBSCRIBER, 1, wire_key('', 7, is_senders=True)),
    declare(Kind.QUERYABLE, 2, _KEY, complete=True) + take_back(Kind.QUERYABLE, 2),
    declare(Kind.TOKEN, 3, wire_key('a/**')) + final() + take_back(Kind.EXPRESSION, 7),
)
_ASKED = (
    interest(1, When.PRESENT | When.FUTURE, About.ALL) + interest(1, When.FINAL),
    interest(2, When.PRESENT, About.TOKENS, 'a/*'),
)
_TOLD = tuple(
    tell_of(Node(bytes(range(1, 17)), role, ('tcp/127.0.0.1:7447', 'tls/[::1]:1')), 3) for role in Role
)
_PUT = (
    push_head(_KEY, 5) + put_body(b'payload', b'attachment', encode_timestamp(5 << 32, b'\1\2')),
    push_head(_KEY, 5) + del_body() + response_final(3, 5),
)


def join_pieces(data: bytes) -> None:
    """Join pieces, as marks and gaps in the input say, with a frame between them here and there.

    Of each three bytes the first says what the piece is, the second how long, the third what it consists of.
    """
    limit = 512
    for has_marks in (True, False):
        reassembly = Reassembly(has_marks=has_marks, budget=PieceBudget(limit))
        for at in range(0, len(data) - 2, 3):
            flags, size, content = data[at : at + 3]
            if flags & 0x80:
                reassembly.clear()
            message = reassembly.add(
                bytes((content,)) * size,
                gap=2 if flags & 0x08 else 1,
                first=bool(flags & 1),
                more=bool(flags & 2),
                given_up=bool(flags & 4),
            )
            assert message is None or len(message) <= limit
            assert sum(map(len, reassembly._pieces or ())) <= limit


def read_addresses(data: bytes) -> None:
    """Addresses, one a line, as routers tell of them: none may ask the network, or take down who reads it."""
    for line in text_of(data).split('\n'):
        try:
            where = parse_address(line)
        except TransportError:
            continue
        if is_quickly_resolved(where.host):
            assert resolve(where)


def read_configuration(data: bytes) -> None:
    """A configuration file, or what is set by a variable: it is refused, opens a session, or is another's."""
    text = text_of(data)
    values = read_settings(text[1:], is_yaml=text[:1] == 'y')
    local_port(value_at(values, 'connect/endpoints'), 'peer')
    with suppress(BeyondOursError):
        opened = native_settings(values)
        assert opened.lease_ms < 1 << 64


_MINIMAL = (
    '{mode: "peer", "connect": {"endpoints": ["tcp/localhost:7447"]}, "scouting": '
    '{"multicast": {"enabled": false}, "gossip": {"target": ["router"]}}, '
    '"transport": {"shared_memory": {"enabled": false}, "link": {"tx": {"lease": 6e4}}}}'
)


def ask_for_history(data: bytes) -> None:
    """Requests of subscribers to publishers that keep messages: subscribers get no more than is kept."""
    one, other, cable = pair()
    publisher = HistoryPublisher(SimpleNamespace(protocol=one), 'k', Publication(one, 'k'), 3, numbers=True)  # type: ignore[arg-type]
    for number in range(5):
        publisher.put(b'%d' % number)
    cable.carry()
    answers: list[object] = []
    querier = Querier(other, 'k/@adv/pub/**', target=QueryTarget.ALL, parameters=f'{text_of(data)};_anyke')
    querier.ask(None, None, answers.append, lambda: answers.append('end'), 10.0)
    cable.carry()
    assert answers[-1:] == ['end']
    assert len(answers) <= 4
    for failure in [*one.failures, *other.failures]:
        raise failure


def _rtps_pair() -> tuple[Network, Participant, Participant]:
    """Return two participants of RTPS with a topic between them, over which a large sample has gone."""
    network = Network()
    network.keeps = True
    one, _ = network.participant(same_host=True)
    other, _ = network.participant(same_host=True)
    publisher, collector = Publisher(), Collector()
    qos = Qos(reliability=RELIABLE, depth=10)
    writer = one.create_writer('t', 'T', qos, publisher)
    other.create_reader('t', 'T', qos, collector)
    assert network.run(1, lambda: publisher.matched and collector.matched)
    writer.write(bytes(70_000))
    assert network.run(1, lambda: collector.samples)
    return network, one, other


def _raise(_where: str, error: Exception) -> None:
    raise error


def hear_rtps(data: bytes) -> None:
    """Hear a packet, behind its header, of the other side of a working pair or, after a 1, of a stranger."""
    network, one, other = _rtps_pair()
    with patch.object(rtps_wire, 'report_failure', _raise):
        head = one.head if data[:1] != b'\1' else one.head[:-1] + b'?'
        source = '10.0.0.1' if data[:1] != b'\1' else '203.0.113.9'
        network.packets.clear()
        other.receive(head + data[1:], (source, 7410))
        network.run(3)
        assert len(network.packets) < 1000
        assert other.kept <= bounds.AHEAD_SIZE
        third, _ = network.participant(same_host=True)
        assert network.run(5, lambda: third.prefix in other._known.remotes)


@cache
def _rtps_packets() -> tuple[bytes, ...]:
    """Return what the first of the pair has sent, one packet of each kind and size."""
    network, _, _ = _rtps_pair()
    sent = [packet for _, source, _, packet in network.packets if source[0] == '10.0.0.1']
    kinds = {
        (packet[HEADER_SIZE], len(packet)): packet[HEADER_SIZE:] for packet in sent if len(packet) < 2000
    }
    return tuple(bytes((number % 2,)) + packet for number, packet in enumerate(kinds.values()))


def read_uri(data: bytes) -> None:
    """A CYCLONEDDS_URI: nothing is opened but regular files."""
    read_cyclone(text_of(data).replace('file:', ''), 7, {})


def read_profiles(data: bytes) -> None:
    """A file of profiles of Fast DDS."""
    with NamedTemporaryFile(prefix='goalwire-fuzz-') as file:
        file.write(data)
        file.flush()
        read_fast_dds('FASTDDS_DEFAULT_PROFILES_FILE', file.name)


_URI = (
    b'<CycloneDDS><Domain id="any"><General><Interfaces><NetworkInterface name="lo"/></></>'
    b'<Discovery><Peers><Peer address="${A:-b}"/></><Ports><Base>7400</></></></></>,<Tracing/>'
)
_PROFILES = (
    b'<dds><profiles><transport_descriptors><transport_descriptor><transport_id>u</transport_id>'
    b'<type>UDPv4</type><interfaceWhiteList><address>127.0.0.1</address></interfaceWhiteList>'
    b'</transport_descriptor></transport_descriptors><participant is_default_profile="true"><rtps>'
    b'<userTransports><transport_id>u</transport_id></userTransports><builtin><initialPeersList><locator>'
    b'<udpv4><address>239.255.0.1</address><port>7400</port></udpv4></locator></initialPeersList></builtin>'
    b'<port><portBase>7400</portBase></port></rtps></participant></profiles></dds>'
)


class _Records:
    """A client that has shaken hands with a server of ours, and what the server then hears of it."""

    def __init__(self) -> None:
        folder = Path(mkdtemp(prefix='goalwire-fuzz-'))
        atexit.register(shutil.rmtree, folder, ignore_errors=True)
        issued = trustme.CA().issue_cert('127.0.0.1')
        issued.private_key_and_cert_chain_pem.write_to_path(str(folder / 'all.pem'))
        path = str(folder / 'all.pem')
        self.server = server_context(TlsFiles(listen_certificate=path, listen_private_key=path))
        self.client = client_context(TlsFiles(verify_name_on_connect=False))
        self.client.verify_mode = ssl.CERT_NONE

    def hear(self, data: bytes) -> None:
        """Let a server of ours hear bytes: in place of the handshake or, after a 1, behind it."""
        near, far = socket.socketpair()
        with near, far:
            near.setblocking(False)
            far.setblocking(False)
            ours, theirs = TlsStream(near, self.server, None), TlsStream(far, self.client, '127.0.0.1')
            if data[:1] == b'\1':
                while not (theirs.shake_hands() and ours.shake_hands()):
                    ours.shake_hands()
                theirs.send(b'said before')
            far.send(data[1:])
            far.shutdown(socket.SHUT_WR)
            with suppress(BlockingIOError):
                if data[:1] == b'\1' or ours.shake_hands():
                    while ours.recv(65536):
                        pass


_hear_records = cache(_Records)


def client_hello() -> bytes:
    """Return the first record of a client."""
    context = ssl.SSLContext(ssl.PROTOCOL_TLS_CLIENT)
    out = ssl.MemoryBIO()
    with suppress(ssl.SSLWantReadError):
        context.wrap_bio(ssl.MemoryBIO(), out, server_hostname='127.0.0.1').do_handshake()
    return out.read()


TARGETS = (
    Target('zenoh_handshake', shake_hands, RemoteError, (_A_SAYS[0][:1],)),
    Target('zenoh_peer', hear_from(Role.PEER), RemoteError, (*_DECLARED, *_PUT)),
    Target('zenoh_client', hear_from(Role.CLIENT), RemoteError, (*_ASKED, *_DECLARED)),
    Target('zenoh_router', hear_from(Role.ROUTER), RemoteError, (*_TOLD, *_DECLARED)),
    Target('zenoh_pieces', join_pieces, RemoteError, (b'\3\x10a\2\x10b\0\x10c', b'\1\xffa\x80\0\0')),
    Target(
        'zenoh_history',
        ask_for_history,
        (),
        (b'_max=2', b'_sn=1..3;_max=1', b'_sn=..', b'_sn=' + b'9' * 5000),
    ),
    Target('zenoh_address', read_addresses, (), (b'tcp/127.0.0.1:7447', b'tls/[::1]:1', b'tcp/localhost:0')),
    Target(
        'zenoh_config',
        read_configuration,
        Json5Error,
        (b' ' + _MINIMAL.encode(), b'ymode: peer', b' {/**/}'),
    ),
    Target('rtps_packet', hear_rtps, RemoteError, _rtps_packets()),
    Target('cyclone_uri', read_uri, TransportError, (_URI, b'<Tracing/>')),
    Target('fast_dds_profiles', read_profiles, TransportError, (_PROFILES,)),
    Target('tls', lambda data: _hear_records().hear(data), OSError, (b'\0' + client_hello(),)),
    Target('zenoh_frames', hear_frames, RemoteError, tuple(_A_SAYS[2:-1])),
    Target('key_expression', read_key_expression, RemoteError, (b'a/**/b', b'0/a$*b/*', b'@ros2_lv/0/**')),
    Target(
        'message', lambda data: parse_message(text_of(data), 'fuzz_msgs', 'It'), InterfaceError, (_MESSAGE,)
    ),
    Target(
        'service',
        lambda data: parse_service(text_of(data), 'fuzz_msgs', 'It'),
        InterfaceError,
        (_MESSAGE + b'---\n' + _MESSAGE, b'---'),
    ),
    Target(
        'action',
        lambda data: parse_action(text_of(data), 'fuzz_msgs', 'It'),
        InterfaceError,
        (_MESSAGE + b'---\n---\n' + _MESSAGE, b'---\n---'),
    ),
    Target('classes', build_classes, InterfaceError, (_MESSAGE, b'')),
    Target('type_name', name_a_type, InterfaceError, (b'std_msgs/msg/String', b'std_srvs/srv/SetBool')),
    Target('cdr', read_message, RemoteError, _messages()),
    Target(
        'attachment',
        read_attachment,
        RemoteError,
        (attachment.encode(3, 5, attachment.GID_SIZE, bytes(16)), bytes(16) + b'\x10' + bytes(16)),
    ),
    Target('token', read_token, RemoteError, (_TOKEN, b'@ros2_lv/0/aa/0/0/NN/%/%/talker')),
    Target('qos', read_qos, RemoteError, (b'::,7:,:,:,,', b'2:1:2,100:1,5:0,7:3,3,4')),
    Target('type', read_type, (), (b'std_msgs::msg::dds_::String_',)),
    Target('request', read_request, RemoteError, (b'\x00\x01\x00\x00' + bytes(16) + b'abc', bytes(21))),
    Target('user_data', read_user_data, (), (b'enclave=/;', b'typehash=RIHS01_0;serviceid=1.2;')),
    Target(
        'participant',
        read_participant,
        RemoteError,
        (
            discovery_state.encode_info(
                discovery_state.ParticipantInfo(
                    bytes(range(16)), (discovery_state.NodeInfo('/', 'talker', (bytes(16),), (bytes(16),)),)
                )
            ),
        ),
    ),
    Target('goals', read_goals, RemoteError, (b'\x00\x01\x00\x00' + bytes(24),)),
    Target('statuses', decode_status_array, RemoteError, (b'\x00\x01\x00\x00\x01\x00\x00\x00' + bytes(25),)),
    Target('nodes', match_nodes, (), (b'/**/a/*/**\n/b/a/c\n/x',)),
    Target('yaml_value', read_yaml_value, (), (b'[1, 2]', b'2020-01-01', b'{a: 1}', b'!!int "3"')),
    Target('entry_points', read_entry_points, (), (b'[goalwire.interfaces]\na_msgs = a.b\n',)),
    Target('parameters', parse_parameter_file, RuleSyntaxError, (_PARAMETERS,)),
    Target(
        'command_line',
        read_command_line,
        (ArgumentError, UnknownArguments),
        (b'-r\na:=b\n-p\nn:x:=[1, 2]\n--log-level\ndebug\n-r\n__ns:=/a', b'-r\nrostopic://a/b:=/c'),
    ),
)
