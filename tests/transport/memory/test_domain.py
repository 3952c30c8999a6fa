"""The domains of a process, and that they go when nobody uses them."""

from __future__ import annotations

import gc
import threading
import weakref
from collections.abc import Callable

import pytest
from helpers.wire import Side

from goalwire.errors import ClosedError
from goalwire.logging import LogRecord
from goalwire.transport import registry
from goalwire.transport.contract import GraphEntity, GraphListener, NodeName, Port, Session, SessionOptions
from goalwire.transport.memory.domain import DOMAINS, MemoryDomain

OpenSession = Callable[[], Session]


def test_a_domain_goes_with_its_last_session() -> None:
    first = DOMAINS.open(7, MemoryDomain)
    DOMAINS.close(7)
    gone = weakref.ref(first)
    del first
    gc.collect()
    assert gone() is None


def test_closed_endpoints_leave_nothing_in_the_domain(open_session: OpenSession) -> None:
    alpha, beta = Side(open_session(), 'alpha'), Side(open_session(), 'beta')
    empty = sizes(domain_of(alpha))
    for side in (alpha, beta):
        ports = [
            side.publisher('/chatter'),
            side.subscription('/chatter', lambda _: None),
            side.service('/add', lambda _: None),
            side.client('/add'),
        ]
        for port in ports:
            port.close()
    assert sizes(domain_of(alpha)) == empty


@pytest.mark.parametrize('kind', ['publisher', 'subscription', 'service', 'client'])
def test_a_node_closed_while_it_declares_leaves_no_ghost(open_session: OpenSession, kind: str) -> None:
    """The node is closed when the domain has the endpoint, before the node has noted it."""
    side = Side(open_session(), 'alpha')
    domain, ports = domain_of(side), side.node.ports  # type: ignore[attr-defined]
    keep = ports.keep

    def close_and_keep(port: Port) -> object:
        side.node.close()
        return keep(port)

    ports.keep = close_and_keep
    deliver = () if kind in {'publisher', 'client'} else (print,)
    with pytest.raises(ClosedError, match='/alpha'):
        getattr(side, kind)('/name', *deliver)
    assert sizes(domain) == [0, 0, 0, 0]


def domain_of(side: Side) -> MemoryDomain:
    domain: MemoryDomain = side.session._domain  # type: ignore[attr-defined]
    return domain


def sizes(domain: MemoryDomain) -> list[int]:
    return [len(domain._publishers), len(domain._subscriptions), len(domain._servers), len(domain._entities)]


def test_a_graph_listener_that_raises_is_logged_and_told_on(
    open_session: OpenSession, records: list[LogRecord]
) -> None:
    calls: list[str] = []

    class Failing(GraphListener):
        def appeared(self, entity: GraphEntity) -> None:
            calls.append(entity.node.name)
            raise ZeroDivisionError

        def vanished(self, entity: GraphEntity) -> None:
            calls.append(f'{entity.node.name} gone')

    session = open_session()
    session.watch_graph(Failing())
    session.node(NodeName('alpha')).close()
    assert calls == ['alpha', 'alpha gone']
    assert 'ZeroDivisionError' in records[-1].message


def test_each_listener_hears_of_things_before_their_end_however_many_threads_declare(
    open_session: OpenSession,
) -> None:
    session = open_session()
    events: list[tuple[str, bytes]] = []

    class Recorder(GraphListener):
        def appeared(self, entity: GraphEntity) -> None:
            events.append(('+', entity.gid))

        def vanished(self, entity: GraphEntity) -> None:
            events.append(('-', entity.gid))

    session.watch_graph(Recorder())

    def come_and_go() -> None:
        for number in range(200):
            session.node(NodeName(f'n{number}')).close()

    threads = [threading.Thread(target=come_and_go) for _ in range(4)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert len(events) == 4 * 200 * 2
    alive: set[bytes] = set()
    for sign, gid in events:
        assert (gid in alive) is (sign == '-')
        alive ^= {gid}


def test_a_child_process_starts_with_an_empty_domain() -> None:
    # This resets the table as a fork does, but without a fork: the contract suite has the real one.
    session = registry.get('goalwire_memory').open(SessionOptions(3))
    try:
        before = DOMAINS._things
        DOMAINS._reset()
        assert DOMAINS.users() == 0
        DOMAINS._things = before
    finally:
        session.close()
