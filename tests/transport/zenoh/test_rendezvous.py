"""The embedded rendezvous: offered, shared, taken over, and missed."""

from __future__ import annotations

import json
import signal
import socket
import time
from collections.abc import Iterator

import pytest
import zenoh
from helpers.collector import Collector
from helpers.processes import Program
from helpers.wire import SeenGraph, Side

from goalwire.errors import TransportError
from goalwire.logging import LogRecord
from goalwire.transport.contract import EndpointKind, SessionOptions
from goalwire.transport.zenoh import TRANSPORT, rendezvous
from goalwire.transport.zenoh.rendezvous import PORT_IS_TAKEN, Offer, is_taken

from .conftest import OpenSide

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
    """What rmw_zenohd is: a zenoh router on the port."""
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
            zenoh.open(router_config(f'tcp/127.0.0.1:{port}'))


def test_a_configuration_that_zenoh_refuses_is_not_taken_for_a_taken_port(world: dict[str, str]) -> None:
    with pytest.raises(TransportError, match='cannot be offered: Unicast not supported'):
        Offer(1, router_config('nosuch/1'))


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
    offer = Offer(port, router_config(f'tcp/127.0.0.1:{port}'))
    try:
        attempts.expect(2)
        assert len(looked.items) >= 4
    finally:
        offer.close()


def router_config(endpoint: str) -> zenoh.Config:
    return zenoh.Config.from_json5(json.dumps({'mode': 'router', 'listen': {'endpoints': [endpoint]}}))


@pytest.mark.slow
@pytest.mark.skipif(not hasattr(signal, 'SIGSTOP'), reason='this system cannot stop a process')
def test_a_frozen_rendezvous_holds_up_a_look_at_the_graph_for_two_seconds(world: dict[str, str]) -> None:
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
    assert 1.5 < took < 4.0


def test_closing_is_quick_for_whoever_waits_for_the_port(world: dict[str, str], open_side: OpenSide) -> None:
    open_side('holder')
    with Program(OPEN, 'waiting', env=world) as waiting:
        waiting.expect('open')
        waiting.write_line('close')
        waiting.expect('closed', timeout=2.0)


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
    programs = [held]
    try:
        held.expect('open')
        for number in range(1, 11):
            programs.append(Program(OPEN, f'n{number}', env=world))
            programs[-1].expect('open')
            programs[-2].kill()
            killed = time.monotonic()
            programs[-2].wait()
            while not answers(port):
                assert time.monotonic() - killed < 1.0, f'nobody took the port over after kill {number}'
    finally:
        for program in programs:
            program.close()


def test_without_a_router_one_is_missed_aloud(
    world: dict[str, str], monkeypatch: pytest.MonkeyPatch, records: list[LogRecord]
) -> None:
    monkeypatch.setenv('GOALWIRE_ROUTER', 'off')
    TRANSPORT.open(SessionOptions()).close()
    assert ['rmw_zenohd' in record.message for record in records] == [True]


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
    start = time.monotonic()
    TRANSPORT.open(SessionOptions()).close()
    assert time.monotonic() - start < 0.4


@pytest.mark.slow
def test_a_port_that_another_program_holds_is_named(world: dict[str, str], port: int) -> None:
    """That program accepts and says nothing: zenoh needs 10 s to hang up, in a process of its own here."""
    with socket.socket() as other:
        other.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        other.bind(('127.0.0.1', port))
        other.listen()
        with Program(OPEN, 'alone', env=world) as alone:
            alone.expect(f'may hold port {port}')
            alone.expect('open')
            alone.write_line('close')
            alone.succeed()


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


def test_an_unreachable_router_of_a_client_is_an_error_that_names_it(
    world: dict[str, str], monkeypatch: pytest.MonkeyPatch, port: int
) -> None:
    monkeypatch.setenv('GOALWIRE_ROUTER', 'off')
    monkeypatch.setenv('ZENOH_CONFIG_OVERRIDE', 'mode="client"')
    with pytest.raises(TransportError, match=f'localhost:{port}'):
        TRANSPORT.open(SessionOptions())


def test_a_client_mode_session_works_through_the_rendezvous(
    monkeypatch: pytest.MonkeyPatch, open_side: OpenSide
) -> None:
    monkeypatch.setenv('ZENOH_CONFIG_OVERRIDE', 'mode="client"')
    one: Side = open_side('one')
    two: Side = open_side('two')
    one.graph.expect(EndpointKind.NODE, '/two')
    two.graph.expect(EndpointKind.NODE, '/one')
