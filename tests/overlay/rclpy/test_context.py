"""Contexts: from init to shutdown, several of them in one process."""

from __future__ import annotations

import gc
from collections.abc import Iterator

import pytest
from helpers.isolation import fresh_domain
from rclpy.context import Context
from rclpy.node import Node

from goalwire.entities.graph_waiting import wait_for_graph
from goalwire.errors import ClosedError, RCLError, TransportError
from goalwire.transport import registry
from goalwire.transport.contract import NodeName, Session, SessionOptions


@pytest.fixture
def fresh(isolated: dict[str, str]) -> Iterator[Context]:
    """A context that was not opened yet."""
    context = Context()
    yield context
    context.try_shutdown()


def test_before_init(fresh: Context) -> None:
    assert not fresh.ok()
    with pytest.raises(RuntimeError, match='must be initialized before it can have a domain id'):
        fresh.get_domain_id()
    with pytest.raises(RuntimeError, match='must be initialized before it can be shutdown'):
        fresh.shutdown()
    fresh.try_shutdown()


def test_a_context_opens_once(fresh: Context) -> None:
    fresh.init(args=[])
    assert fresh.ok()
    with pytest.raises(RuntimeError, match='must only be called once'):
        fresh.init(args=[])
    fresh.shutdown()
    assert not fresh.ok()
    with pytest.raises(
        RCLError, match=r'^failed to shutdown: rcl_shutdown already called on the given context$'
    ):
        fresh.shutdown()
    fresh.try_shutdown()
    with pytest.raises(RuntimeError, match='must only be called once'):
        fresh.init(args=[])


def test_shutdown_callbacks_run_once_in_order(fresh: Context) -> None:
    called: list[str] = []
    fresh.init(args=[])
    fresh.on_shutdown(lambda: called.append('first'))
    fresh.on_shutdown(lambda: called.append('second'))
    fresh.shutdown()
    fresh.try_shutdown()
    assert called == ['first', 'second']
    fresh.on_shutdown(lambda: called.append('late'))
    assert called == ['first', 'second', 'late']


def test_what_cannot_be_called_is_no_shutdown_callback(fresh: Context) -> None:
    fresh.init(args=[])
    with pytest.raises(TypeError, match='callback should be a callable'):
        fresh.on_shutdown('x')  # type: ignore[arg-type]


def test_methods_are_held_weakly_as_shutdown_callbacks(fresh: Context) -> None:
    called: list[str] = []

    class Listener:
        def __init__(self, name: str) -> None:
            self.name = name

        def listen(self) -> None:
            called.append(self.name)

    fresh.init(args=[])
    gone, kept = Listener('gone'), Listener('kept')
    fresh.on_shutdown(gone.listen)
    fresh.on_shutdown(kept.listen)
    del gone
    gc.collect()
    fresh.shutdown()
    assert called == ['kept']


def test_a_raising_shutdown_callback_still_closes_the_session(fresh: Context) -> None:
    def boom() -> None:
        raise ValueError('boom')

    fresh.init(args=[])
    Node('a', context=fresh)
    fresh.on_shutdown(boom)
    with pytest.raises(ValueError, match='boom'):
        fresh.shutdown()
    assert not fresh.ok()
    assert fresh._session is None


def test_a_context_is_a_block(isolated: dict[str, str], monkeypatch: pytest.MonkeyPatch) -> None:
    import sys

    monkeypatch.setattr(sys, 'argv', ['prog'])
    with Context() as context:
        assert context.ok()
    assert not context.ok()


def test_an_open_context_is_a_block_too_as_in_newer_rclpy(fresh: Context) -> None:
    fresh.init(args=[])
    with fresh as context:
        assert context is fresh
        assert context.ok()
    assert not fresh.ok()


def test_the_domain_is_the_environment_s_or_the_given_one(isolated: dict[str, str], fresh: Context) -> None:
    other, domain = Context(), fresh_domain()
    fresh.init(args=[])
    other.init(args=[], domain_id=domain)
    assert fresh.get_domain_id() == int(isolated['ROS_DOMAIN_ID'])
    assert other.get_domain_id() == domain
    other.shutdown()
    assert fresh.ok()


def test_two_contexts_of_one_domain_see_each_other(fresh: Context) -> None:
    other = Context()
    fresh.init(args=[])
    other.init(args=[])
    try:
        here = Node('here', context=fresh)
        there = Node('there', context=other)
        assert here.wait_for_node('/there', 10.0)
        assert there.wait_for_node('/here', 10.0)
    finally:
        other.shutdown()


def test_no_session_is_opened_before_the_first_node(fresh: Context) -> None:
    """So a program may fork after init()."""
    fresh.init(args=[])
    assert fresh._session is None
    Node('a', context=fresh)
    assert fresh._session is not None


def test_a_node_needs_an_open_context(fresh: Context) -> None:
    from rclpy.exceptions import NotInitializedException

    with pytest.raises(NotInitializedException):
        Node('a', context=fresh)
    fresh.init(args=[])
    fresh.shutdown()
    with pytest.raises(NotInitializedException):
        Node('a', context=fresh)


def test_two_servers_of_others_are_none_of_a_contexts_business(
    context: Context, fresh: Context, capfd: pytest.CaptureFixture[str]
) -> None:
    from std_srvs.srv import Trigger

    fresh.init(args=[])
    bystander = Node('bystander', context=fresh)
    servers = [Node(f'server{number}', context=context) for number in range(2)]
    for server in servers:
        server.create_service(Trigger, 'go', lambda _, response: response)
    assert wait_for_graph(fresh, lambda: bystander.count_services('go') == 2, 10)
    assert wait_for_graph(context, lambda: servers[0].count_services('go') == 2, 10)
    assert capfd.readouterr().err.count("'/go' is served twice") == 1


def test_a_session_whose_graph_cannot_be_watched_is_closed(
    fresh: Context, monkeypatch: pytest.MonkeyPatch
) -> None:
    fresh.init(args=[])
    opened: list[Session] = []

    def refuse(session: Session, _: object) -> None:
        opened.append(session)
        raise TransportError('no answer')

    monkeypatch.setattr(type(open_one()), 'watch_graph', refuse)
    with pytest.raises(TransportError, match='no answer'):
        Node('node', context=fresh)
    with pytest.raises(ClosedError):
        opened[0].node(NodeName('late'))


def open_one() -> Session:
    session = registry.get().open(SessionOptions(fresh_domain()))
    session.close()
    return session
