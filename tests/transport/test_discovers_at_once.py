"""A session's promise about its first look at the graph: tools wait for no longer than they must."""

from __future__ import annotations

import socket
import subprocess
import sys
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager
from threading import Event

import pytest
from helpers.isolation import isolated_env
from helpers.patience import wait_for

from goalwire.graph.graph import Graph
from goalwire.transport import registry
from goalwire.transport.contract import GraphEntity, NodeName, Session, SessionOptions
from goalwire.transport.dds.environment import ports_in_use

WIRES = {
    ('rmw_zenoh_cpp', 'native'): True,
    ('rmw_zenoh_cpp', 'eclipse'): False,
    ('rmw_cyclonedds_cpp', ''): False,
    ('goalwire_memory', ''): True,
}


@pytest.mark.parametrize('named', WIRES, ids=' '.join)
def test_a_session_says_whether_its_first_look_is_complete(
    named: tuple[str, str], monkeypatch: pytest.MonkeyPatch
) -> None:
    for name, value in {**isolated_env(named[0]), 'GOALWIRE_ZENOH': named[1]}.items():
        monkeypatch.setenv(name, value)
    session = registry.get(named[0]).open(SessionOptions(domain_id=1))
    try:
        assert session.discovers_at_once is WIRES[named]
    finally:
        session.close()


def on_dds(monkeypatch: pytest.MonkeyPatch) -> tuple[dict[str, str], int]:
    """Choose DDS and a domain where nobody is."""
    env = isolated_env('rmw_cyclonedds_cpp')
    for name, value in env.items():
        monkeypatch.setenv(name, value)
    return env, int(env['ROS_DOMAIN_ID'])


class _Seen(Graph):
    """A graph that asks its session, with every news, whether that was all."""

    def __init__(self, session: Session) -> None:
        super().__init__()
        self._session = session
        self.answers: list[bool] = []
        self.told = Event()

    def appeared(self, entity: GraphEntity) -> None:
        self.answers.append(self._session.has_heard_all())
        super().appeared(entity)
        if self.node_exists('told'):
            self.told.set()


def test_on_dds_a_session_has_heard_all_once_listeners_have_been_told(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """Not while it is just telling them: a list that is made then misses what comes."""
    options = SessionOptions(domain_id=on_dds(monkeypatch)[1])
    first, second = (registry.get('rmw_cyclonedds_cpp').open(options) for _ in range(2))
    try:
        graph = _Seen(second)
        second.watch_graph(graph)
        first.node(NodeName('told'))
        assert graph.told.wait(20)
        wait_for(second.has_heard_all)
        assert not any(graph.answers)
    finally:
        second.close()
        first.close()


LISTENER = """
import socket, sys
with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as listener:
    listener.bind(('', int(sys.argv[1])))
    print('bound', flush=True)
    sys.stdin.read()
"""
WITHOUT_NODES = """
import sys
from goalwire.transport import registry
from goalwire.transport.contract import SessionOptions
session = registry.get('rmw_cyclonedds_cpp').open(SessionOptions(domain_id=int(sys.argv[1])))
print('open', flush=True)
sys.stdin.read()
session.close()
"""
only_linux = pytest.mark.skipif(sys.platform != 'linux', reason='only Linux tells who listens at which port')


@contextmanager
def beside(program: str, argument: int, env: dict[str, str] | None = None) -> Iterator[None]:
    """Run a program that prints a line and then waits for the end of its input."""
    arguments = [sys.executable, '-c', program, str(argument)]
    with subprocess.Popen(arguments, env=env, stdin=subprocess.PIPE, stdout=subprocess.PIPE) as process:
        assert process.stdout is not None
        assert process.stdout.readline()
        yield
        process.communicate()


@only_linux
def test_on_dds_a_process_that_listens_and_was_not_met_is_waited_for(monkeypatch: pytest.MonkeyPatch) -> None:
    """A participant that is slow to answer is not missed: its port tells that it is there."""
    _, domain_id = on_dds(monkeypatch)
    port = 7400 + 250 * domain_id + 10 + 2 * 30
    with ExitStack() as stack:
        session = registry.get('rmw_cyclonedds_cpp').open(SessionOptions(domain_id=domain_id))
        stack.callback(session.close)
        assert session.has_heard_all()
        with beside(LISTENER, port):
            assert ports_in_use(domain_id) == {port}
            assert not session.has_heard_all()
        assert session.has_heard_all()
        listener = stack.enter_context(socket.socket(socket.AF_INET, socket.SOCK_DGRAM))
        listener.bind(('', port))
        assert ports_in_use(domain_id) == set()  # this process' own
        assert session.has_heard_all()


@only_linux
def test_the_peers_are_known_where_nobody_else_can_answer(monkeypatch: pytest.MonkeyPatch) -> None:
    _, domain_id = on_dds(monkeypatch)
    for variables, is_known in (
        ({'ROS_AUTOMATIC_DISCOVERY_RANGE': 'LOCALHOST'}, True),
        ({'ROS_AUTOMATIC_DISCOVERY_RANGE': 'SUBNET'}, False),
        ({'ROS_AUTOMATIC_DISCOVERY_RANGE': 'LOCALHOST', 'ROS_STATIC_PEERS': '127.0.0.1'}, False),
    ):
        for name, value in variables.items():
            monkeypatch.setenv(name, value)
        session = registry.get('rmw_cyclonedds_cpp').open(SessionOptions(domain_id=domain_id))
        session.close()
        assert session.knows_its_peers is is_known


def test_on_dds_a_session_without_nodes_is_not_waited_for(monkeypatch: pytest.MonkeyPatch) -> None:
    """It says that it has none. A command would wait for the whole of its --spin-time otherwise."""
    env, domain_id = on_dds(monkeypatch)
    with beside(WITHOUT_NODES, domain_id, env):
        arguments = [sys.executable, '-m', 'goalwire', 'service', 'list', '--spin-time', '600']
        done = subprocess.run(arguments, env=env, capture_output=True, text=True, timeout=60, check=False)
    assert (done.returncode, done.stdout, done.stderr) == (0, '', '')
