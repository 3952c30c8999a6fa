"""The embedded rendezvous: offered, shared, taken over, and missed."""

from __future__ import annotations

import json
import signal
import socket
import statistics
import sys
import threading
import time
from collections.abc import Iterator
from contextlib import ExitStack
from pathlib import Path

import pytest
import zenoh
from helpers.collector import Collector
from helpers.command_line import executable
from helpers.held_up import HeldUp
from helpers.isolation import free_port
from helpers.patience import PATIENCE, wait_for
from helpers.processes import Program
from helpers.wire import SeenGraph, Side

from goalwire.errors import TransportError
from goalwire.logging import LogRecord
from goalwire.security.keystore import Keystore
from goalwire.transport.contract import EndpointKind, SessionOptions
from goalwire.transport.zenoh import TRANSPORT, rendezvous, threads
from goalwire.transport.zenoh.embedded_router import PORT_IS_TAKEN
from goalwire.transport.zenoh.rendezvous import RENDEZVOUS, EmbeddedRouter, Holder, is_taken
from goalwire.transport.zenoh.settings.environment import ECLIPSE, NATIVE
from goalwire.transport.zenoh.settings.values import Configuration

from .conftest import OpenSide, on_both

OPEN = """
import os, sys
from goalwire.transport.contract import NodeName, SessionOptions
from goalwire.transport.zenoh import TRANSPORT
session = TRANSPORT.open(SessionOptions(int(os.environ['ROS_DOMAIN_ID'])))
node = session.node(NodeName(sys.argv[1]))
print('open', flush=True)
sys.stdin.readline()
session.close()
print('closed', flush=True)
"""


def answers(port: int) -> bool:
    with socket.socket() as probe:
        return probe.connect_ex(('127.0.0.1', port)) == 0


@pytest.fixture
def port(world: dict[str, str]) -> int:
    return int(world['GOALWIRE_ROUTER_PORT'])


@pytest.fixture
def plain_router(port: int) -> Iterator[zenoh.Session]:
    """A zenoh router on the port, which is what rmw_zenohd is."""
    settings = {
        'mode': 'router',
        'listen': {'endpoints': [f'tcp/127.0.0.1:{port}']},
        'scouting': {'delay': 0, 'multicast': {'enabled': False}},
        'transport': {'shared_memory': {'enabled': False}},
    }
    router = zenoh.open(zenoh.Config.from_json5(json.dumps(settings)))
    yield router
    router.close()  # type: ignore[no-untyped-call]


def test_it_answers_as_long_as_a_session_of_the_process_is_open(open_side: OpenSide, port: int) -> None:
    one, two = open_side('one'), open_side('two')
    assert answers(port)
    one.session.close()
    assert answers(port)
    two.session.close()
    assert not answers(port)


def test_zenoh_still_says_that_a_port_is_taken_as_we_expect(world: dict[str, str], port: int) -> None:
    """With another text, every second program of a machine would be turned away."""
    with socket.socket() as other:
        other.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        other.bind(('127.0.0.1', port))
        other.listen()
        with pytest.raises(zenoh.ZError, match=PORT_IS_TAKEN):
            zenoh.open(zenoh.Config.from_json5(json.dumps(router_config(f'tcp/127.0.0.1:{port}').values)))


def test_a_configuration_that_zenoh_refuses_is_not_taken_for_a_taken_port(world: dict[str, str]) -> None:
    with pytest.raises(TransportError, match='cannot be offered: Unicast not supported'):
        EmbeddedRouter(1, router_config('nosuch/1'))


@pytest.mark.parametrize(
    'endpoint',
    ['tcp/127.0.0.1:{}', 'tcp/localhost:{}', 'tcp/[::]:{}', 'tcp/0.0.0.0:{}', 'tls/127.0.0.1:{}#a=b'],
)
def test_a_port_is_taken_while_somebody_listens_there(
    world: dict[str, str], port: int, endpoint: str
) -> None:
    endpoints = json.dumps({'router': ['udp/127.0.0.1:1', endpoint.format(port)]})
    assert not is_taken(endpoints)
    with socket.create_server(('127.0.0.1', port)):
        assert is_taken(endpoints)
    assert not is_taken(endpoints)


@pytest.mark.parametrize('endpoint', ['udp/127.0.0.1:{}', 'tcp/some.name:{}', 'tcp/192.0.2.1:{}'])
def test_where_a_socket_cannot_tell_zenoh_is_asked(world: dict[str, str], port: int, endpoint: str) -> None:
    with socket.create_server(('127.0.0.1', port)):
        assert not is_taken(json.dumps([endpoint.format(port)]))


def test_while_a_port_is_taken_zenoh_is_not_asked_again(
    world: dict[str, str], port: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Each attempt of zenoh's that fails costs memory for ever."""
    attempts, looked = Collector[object](), Collector[str]()

    def fail(config: zenoh.Config) -> zenoh.Session:
        attempts(config)
        raise zenoh.ZError(f'cannot start a {PORT_IS_TAKEN}')

    def look(endpoints: str) -> bool:
        looked(endpoints)
        return len(looked.items) < 4

    monkeypatch.setattr(zenoh, 'open', fail)
    monkeypatch.setattr(rendezvous, 'is_taken', look)
    monkeypatch.setattr(rendezvous, 'RETRY_S', 0.001)
    offer = EmbeddedRouter(port, router_config(f'tcp/127.0.0.1:{port}'))
    try:
        attempts.expect(2)
        assert len(looked.items) >= 4
    finally:
        offer.close()


def router_config(endpoint: str) -> Configuration:
    return Configuration({'mode': 'router', 'listen': {'endpoints': [endpoint]}})


@pytest.mark.slow
@pytest.mark.skipif(not hasattr(signal, 'SIGSTOP'), reason='this system cannot stop a process')
def test_a_frozen_rendezvous_does_not_hold_up_a_look_at_the_graph_for_ever(world: dict[str, str]) -> None:
    with Program(OPEN, 'frozen', env=world) as frozen:
        frozen.expect('open')
        session = TRANSPORT.open(SessionOptions(int(world['ROS_DOMAIN_ID'])))
        frozen.send_signal(signal.SIGSTOP)
        try:
            start = time.monotonic()
            session.watch_graph(SeenGraph())
            took = time.monotonic() - start
        finally:
            frozen.send_signal(signal.SIGCONT)
            session.close()
    assert took < 10.0  # a session of eclipse-zenoh asks for 2 s; one of ours knows, and need not ask


def test_closing_is_quick_for_whoever_waits_for_the_port(world: dict[str, str], open_side: OpenSide) -> None:
    open_side('holder')
    with Program(OPEN, 'waiting', env=world) as waiting:
        waiting.expect('open')
        held_up, asked = HeldUp(waiting.pid), time.monotonic()
        waiting.write_line('close')
        waiting.expect('closed')
        assert time.monotonic() - asked < 2.0 + held_up.seconds


def test_two_that_start_at_the_same_moment_find_each_other(
    world: dict[str, str], open_side: OpenSide
) -> None:
    with Program(OPEN, 'left', env=world) as left, Program(OPEN, 'right', env=world) as right:
        ours = open_side('ours')
        ours.graph.expect(EndpointKind.NODE, '/left')
        ours.graph.expect(EndpointKind.NODE, '/right')
        for program in (left, right):
            program.expect('open')
            program.write_line('close')
            program.succeed()
        ours.graph.expect(EndpointKind.NODE, '/left', number=0)


@pytest.mark.slow
def test_a_killed_holder_is_replaced_within_a_second_ten_times(world: dict[str, str], port: int) -> None:
    held = Program(OPEN, 'n0', env=world)
    programs, took = [held], list[float]()
    try:
        held.expect('open')
        for number in range(1, 11):
            programs.append(Program(OPEN, f'n{number}', env=world))
            programs[-1].expect('open')
            programs[-2].kill()
            killed = time.monotonic()
            programs[-2].wait()
            while not answers(port):
                assert time.monotonic() - killed < PATIENCE, f'nobody took the port over after kill {number}'
            took.append(time.monotonic() - killed)
        assert statistics.median(took) < 1.0
    finally:
        for program in programs:
            program.close()


def test_without_a_router_one_is_missed_aloud(
    world: dict[str, str], monkeypatch: pytest.MonkeyPatch, records: list[LogRecord]
) -> None:
    monkeypatch.setenv('GOALWIRE_ROUTER', 'off')
    TRANSPORT.open(SessionOptions()).close()
    assert ['start one (ros2 router; ' in record.message for record in records] == [True]


@pytest.fixture
def plain_peer() -> Iterator[str]:
    """A zenoh peer that others are told to connect to: its address."""
    address = f'tcp/127.0.0.1:{free_port()}'
    settings = {
        'mode': 'peer',
        'listen': {'endpoints': [address]},
        'scouting': {'multicast': {'enabled': False}},
        'transport': {'shared_memory': {'enabled': False}},
    }
    peer = threads.open_session(zenoh.Config.from_json5(json.dumps(settings)))
    yield address
    peer.close()  # type: ignore[no-untyped-call]


@pytest.mark.parametrize('world', [NATIVE, ECLIPSE], indirect=True)
def test_a_peer_that_answers_where_a_router_was_expected_is_no_reason_to_warn(
    world: dict[str, str], plain_peer: str, monkeypatch: pytest.MonkeyPatch, records: list[LogRecord]
) -> None:
    monkeypatch.setenv('GOALWIRE_ROUTER', 'off')
    monkeypatch.setenv('ZENOH_CONFIG_OVERRIDE', f'connect/endpoints=["{plain_peer}"]')
    TRANSPORT.open(SessionOptions()).close()
    assert [record.message for record in records] == []


def test_the_check_for_a_router_can_be_turned_off(
    world: dict[str, str], monkeypatch: pytest.MonkeyPatch, records: list[LogRecord]
) -> None:
    monkeypatch.setenv('GOALWIRE_ROUTER', 'off')
    monkeypatch.setenv('ZENOH_ROUTER_CHECK_ATTEMPTS', '-1')
    TRANSPORT.open(SessionOptions()).close()
    assert records == []


def test_opening_costs_no_half_second_where_no_router_answers(
    world: dict[str, str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv('GOALWIRE_ROUTER', 'off')
    took = []
    for _ in range(5):
        start = time.monotonic()
        TRANSPORT.open(SessionOptions()).close()
        took.append(time.monotonic() - start)
    assert min(took) < 0.4


@pytest.fixture
def stranger(request: pytest.FixtureRequest, port: int) -> Iterator[None]:
    """A program on the port that is not a router: it says nothing, hangs up, or speaks HTTP."""
    with Program(STRANGER, str(port), request.param) as program:
        program.expect('ready')
        yield


HTTP = b'HTTP/1.1 400 Bad Request\r\n\r\n'
STRANGER = f"""
import socket, sys
with socket.create_server(('127.0.0.1', int(sys.argv[1]))) as server:
    print('ready', flush=True)
    held = []
    while True:
        connection, _ = server.accept()
        if sys.argv[2] == 'mute':
            held.append(connection)
        elif sys.argv[2] == 'http':
            connection.sendall({HTTP!r})
        else:
            connection.close()
"""


@pytest.mark.slow
@pytest.mark.parametrize(
    ('stranger', 'what'),
    [
        ('mute', 'accepts connections and says nothing'),
        ('rude', 'does not speak Zenoh'),
        ('http', 'does not speak Zenoh'),
    ],
    indirect=['stranger'],
)
@pytest.mark.parametrize('choice', ['auto', 'off'])
def test_who_holds_the_port_and_is_no_router_is_named_and_costs_little(
    world: dict[str, str], port: int, stranger: None, what: str, choice: str
) -> None:
    """Where it says nothing, zenoh itself needs 10 s to give its closing up, and says so."""
    with Program(OPEN, 'alone', env=world | {'GOALWIRE_ROUTER': choice}) as alone:
        alone.expect(f'port {port} is held by')
        alone.expect('open')
        alone.write_line('close')
        output = alone.succeed()
    assert 'cut short' not in output
    lines = [line for line in output.splitlines() if 'WARN' in line]
    assert len(lines) == 1, output
    (line,) = lines
    assert what in line
    assert 'GOALWIRE_ROUTER_PORT' in line
    if sys.platform == 'linux':
        assert ' (process ' in line


def test_a_holder_is_told_by_its_answer(port: int, world: dict[str, str]) -> None:
    assert rendezvous.look(port) is Holder.NOBODY
    with socket.create_server(('127.0.0.1', port)):
        assert rendezvous.look(port, 0.1) is Holder.MUTE
    assert rendezvous.look(port) is Holder.NOBODY


def test_a_router_is_told_by_its_answer(port: int, plain_router: zenoh.Session) -> None:
    assert rendezvous.look(port) is Holder.ZENOH


@pytest.fixture
def secured(world: dict[str, str], tmp_path: Path) -> dict[str, str]:
    """The environment of a program with security."""
    keystore = Keystore.create(tmp_path / 'keys')
    keystore.add('robby', 'robot', ())
    return world | {'GOALWIRE_SECURITY': f'{keystore.path}:robby'}


def test_a_program_without_security_is_told_to_have_it_too(
    secured: dict[str, str], world: dict[str, str], port: int
) -> None:
    """It was told to end the program with security, since that one hangs up at a greeting without TLS."""
    with Program(OPEN, 'secured', env=secured) as holder:
        holder.expect('open')
        wait_for(lambda: answers(port))
        assert rendezvous.look(port) is Holder.TLS
        with Program(OPEN, 'plain', env=world) as plain:
            plain.expect('which speaks TLS, while this .* export GOALWIRE_SECURITY=KEYSTORE:NAME')
            plain.expect('open')


def test_a_program_with_security_is_told_of_a_holder_without(
    secured: dict[str, str], port: int, open_side: OpenSide
) -> None:
    open_side('plain')
    with Program(OPEN, 'secured', env=secured) as program:
        program.expect(f'port {port} is held by .* which has no security: set GOALWIRE_SECURITY for it, too')
        program.expect('open')


@pytest.mark.slow
def test_a_program_without_security_is_told_to_have_it_too_beside_a_router(
    secured: dict[str, str], world: dict[str, str], tmp_path: Path, port: int
) -> None:
    """eclipse-zenoh's router answers with an alert of TLS, which was taken for an answer of Zenoh's."""
    Keystore(tmp_path / 'keys').add('site', 'router', ())
    of_router = secured | {'GOALWIRE_SECURITY': f'{tmp_path}/keys:site'}
    with Program(executable(), 'router', '--secure', env=of_router) as router:
        router.expect('listens on')
        assert rendezvous.look(port) is Holder.TLS
        with Program(OPEN, 'plain', env=world) as plain:
            plain.expect('which speaks TLS, while this .* export GOALWIRE_SECURITY=KEYSTORE:NAME')
            plain.expect('open')


def test_a_rendezvous_answers_as_a_router(port: int, open_side: OpenSide) -> None:
    open_side('one')
    assert rendezvous.look(port) is Holder.ZENOH


ROUTER = """
import json, sys, zenoh
settings = {
    'mode': 'router',
    'listen': {'endpoints': ['tcp/0.0.0.0:' + sys.argv[1]]},
    'scouting': {'delay': 0, 'multicast': {'enabled': False}},
    'transport': {'shared_memory': {'enabled': False}},
}
with zenoh.open(zenoh.Config.from_json5(json.dumps(settings))):
    print('routing', flush=True)
    sys.stdin.readline()
"""


def waits_for_port() -> bool:
    return any(thread.name.startswith('rendezvous') for thread in threading.enumerate())


@pytest.mark.slow
def test_a_real_router_that_dies_gets_its_port_back(
    world: dict[str, str], port: int, open_side: OpenSide
) -> None:
    with ExitStack() as stack:
        router = stack.enter_context(Program(ROUTER, str(port)))
        router.expect('routing')  # before anybody else takes the port
        there = stack.enter_context(Program(OPEN, 'there', env=world))
        ours = open_side('ours')
        there.expect('open')
        ours.graph.expect(EndpointKind.NODE, '/there')
        router.kill()
        router.wait()
        wait_for(lambda: not waits_for_port())
        time.sleep(5 * rendezvous.RETRY_S)  # what would take the port would do so now
        assert not answers(port)
        ours.graph.expect(EndpointKind.NODE, '/there')  # who had met stays together
        with Program(ROUTER, str(port)) as again:
            again.expect('routing')
            later = open_side('later')
            later.graph.expect(EndpointKind.NODE, '/there')
            there.write_line('close')
            there.succeed()


@pytest.mark.slow
def test_a_router_with_security_that_dies_gets_its_port_back(
    secured: dict[str, str],
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    port: int,
    open_side: OpenSide,
) -> None:
    """Programs with security took the port, and the router ended with "port ... is held by"."""
    Keystore(tmp_path / 'keys').add('site', 'router', ())
    of_router = secured | {'GOALWIRE_SECURITY': f'{tmp_path}/keys:site'}
    monkeypatch.setenv('GOALWIRE_SECURITY', secured['GOALWIRE_SECURITY'])
    with ExitStack() as stack:
        router = stack.enter_context(Program(executable(), 'router', '--secure', env=of_router))
        router.expect('listens on')  # before anybody else takes the port
        there = stack.enter_context(Program(OPEN, 'there', env=secured))
        ours = open_side('ours')
        there.expect('open')
        ours.graph.expect(EndpointKind.NODE, '/there')
        wait_for(lambda: RENDEZVOUS.is_left(port))
        router.kill()
        router.wait()
        time.sleep(5 * rendezvous.RETRY_S)  # what would take the port would do so now
        assert not answers(port)
        ours.graph.expect(EndpointKind.NODE, '/there')  # who had met stays together
        with Program(executable(), 'router', '--secure', env=of_router) as again:
            again.expect('listens on')
            there.write_line('close')
            there.succeed()


@pytest.mark.slow
@pytest.mark.parametrize('has_security', [False, True], ids=['a program without', 'a program with'])
def test_a_router_gets_its_port_back_from_a_program_that_cannot_use_it(
    secured: dict[str, str],
    world: dict[str, str],
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    port: int,
    open_side: OpenSide,
    *,
    has_security: bool,
) -> None:
    """One of the two has security and the other has none. Such a program took the port at once, for good."""
    Keystore(tmp_path / 'keys').add('site', 'router', ())
    command, env = ['router'], world
    if has_security:
        monkeypatch.setenv('GOALWIRE_SECURITY', secured['GOALWIRE_SECURITY'])
    else:
        command, env = ['router', '--secure'], secured | {'GOALWIRE_SECURITY': f'{tmp_path}/keys:site'}
    with Program(executable(), *command, env=env) as router:
        router.expect('listens on')
        open_side('ours')
        router.kill()
        router.wait()
    time.sleep(5 * rendezvous.RETRY_S)  # what would take the port would do so now
    assert not answers(port)
    with Program(executable(), *command, env=env) as again:
        again.expect('listens on')
    monkeypatch.setattr(rendezvous, 'HESITATION_S', 0.0)  # it is over
    wait_for(lambda: RENDEZVOUS.holds(port))


def test_a_port_left_to_a_router_is_left_for_good(
    port: int,
    plain_router: zenoh.Session,
    open_side: OpenSide,
    records: list[LogRecord],
) -> None:
    open_side('one')
    wait_for(lambda: RENDEZVOUS.is_left(port))
    plain_router.close()  # type: ignore[no-untyped-call]
    open_side('two')
    assert not answers(port)
    assert ['start one (ros2 router; ' in record.message for record in records] == [True]


def test_a_rendezvous_of_another_process_is_replaced_as_ever(
    world: dict[str, str], port: int, open_side: OpenSide
) -> None:
    with Program(OPEN, 'holder', env=world) as program:
        program.expect('open')
        ours = open_side('ours')
        ours.graph.expect(EndpointKind.NODE, '/holder')
        assert not RENDEZVOUS.is_left(port)
        program.kill()
        program.wait()
        wait_for(lambda: RENDEZVOUS.holds(port))


def test_a_rendezvous_that_is_asked_for_gives_way_to_nobody(
    world: dict[str, str],
    port: int,
    plain_router: zenoh.Session,
    open_side: OpenSide,
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setenv('GOALWIRE_ROUTER', 'on')
    open_side('one')
    plain_router.close()  # type: ignore[no-untyped-call]
    wait_for(lambda: RENDEZVOUS.holds(port))


@pytest.mark.parametrize('choice', ['auto', 'off'])
def test_a_router_that_is_there_already_is_used(
    monkeypatch: pytest.MonkeyPatch,
    world: dict[str, str],
    plain_router: zenoh.Session,
    open_side: OpenSide,
    records: list[LogRecord],
    choice: str,
) -> None:
    monkeypatch.setenv('GOALWIRE_ROUTER', choice)
    one, two = open_side('one'), open_side('two')
    one.graph.expect(EndpointKind.NODE, '/two')
    two.graph.expect(EndpointKind.NODE, '/one')
    assert records == []


@on_both
def test_an_unreachable_router_of_a_client_is_an_error_that_names_it_and_says_how_to_start_one(
    world: dict[str, str], monkeypatch: pytest.MonkeyPatch, port: int
) -> None:
    monkeypatch.setenv('GOALWIRE_ROUTER', 'off')
    monkeypatch.setenv('ZENOH_CONFIG_OVERRIDE', 'mode="client"')
    with pytest.raises(TransportError, match=rf'localhost:{port}.*start one \(ros2 router'):
        TRANSPORT.open(SessionOptions())


def test_a_client_mode_session_works_through_the_rendezvous(
    monkeypatch: pytest.MonkeyPatch, open_side: OpenSide
) -> None:
    monkeypatch.setenv('ZENOH_CONFIG_OVERRIDE', 'mode="client"')
    one: Side = open_side('one')
    two: Side = open_side('two')
    one.graph.expect(EndpointKind.NODE, '/two')
    two.graph.expect(EndpointKind.NODE, '/one')
