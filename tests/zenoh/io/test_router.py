"""A router of ours, between sessions of both makes: peers that meet there, and clients that it serves."""

from __future__ import annotations

from collections.abc import Iterator

import pytest
from helpers.leaks import Inventory
from helpers.patience import wait_for
from helpers.zenoh_sides import Ours, Side, Theirs, address

MAKES = pytest.mark.parametrize(
    'makes',
    [(Ours, Ours), (Ours, Theirs), (Theirs, Ours), (Theirs, Theirs)],
    ids=lambda pair: f'{pair[0].make}-{pair[1].make}',
)
MODES = pytest.mark.parametrize('modes', ['client-client', 'client-peer', 'peer-client'])
SIZES = [0, 1, 127, 128, 16383, 65536, 1_000_000, 3]


@pytest.fixture
def sides() -> Iterator[list[Side]]:
    """The sessions of a test; they are closed after it, the last first."""
    opened: list[Side] = []
    before = Inventory()
    yield opened
    for side in reversed(opened):
        side.close()
    # eclipse-zenoh lets go of its sockets a moment after its session is closed.
    wait_for(lambda: not before.added_descriptors(), 'the sockets to be closed')


@pytest.fixture
def router(sides: list[Side]) -> str:
    """The address of a router."""
    where = address()
    sides.append(Ours('router', listen=(where,)))
    return where


@pytest.fixture
def pair(makes: tuple[type[Side], type[Side]], modes: str, router: str, sides: list[Side]) -> list[Side]:
    """Two sessions that know the router alone."""
    opened = [
        make(mode, connect=(router,))  # type: ignore[call-arg]
        for make, mode in zip(makes, modes.split('-'), strict=True)
    ]
    sides += opened
    return opened


@MAKES
@MODES
def test_a_client_and_another_session_reach_each_other(pair: list[Side]) -> None:
    for number, (one, other) in enumerate((pair, pair[::-1])):
        heard = other.subscribe('a/*')
        other.serve(f'q/{number}', b'yes ')
        other.serve(f'e/{number}', None, error=b'no')
        other.token(f'ready/{number}')
        one.watch('ready/**').wait(1)
        wait_for(lambda: one.ask(f'e/{number}').wait() == [('error', b'no')], 'the queryables')  # noqa: B023
        for size in SIZES:
            one.put('a/b', bytes(size))
        came = [(key, len(payload or b'')) for key, payload in heard.wait(len(SIZES))]
        assert came == [('a/b', size) for size in SIZES]
        assert one.ask(f'q/{number}', b'?').wait() == [(f'q/{number}', b'yes ?')]
        assert one.ask(f'q/{number}', bytes(300_000)).wait() == [(f'q/{number}', b'yes ' + bytes(300_000))]
        assert one.ask('nobody').wait() == []


@MAKES
@MODES
def test_what_a_lost_session_had_declared_is_taken_back(pair: list[Side], sides: list[Side]) -> None:
    one, other = pair
    other.token('there')
    other.serve('slow', None)
    watch = one.watch('there')
    watch.wait(1)
    wait_for(lambda: other.held or not one.ask('slow', timeout_s=0.1).wait(), 'a query on its way')
    asked = one.ask('slow', timeout_s=60.0)
    other.close()
    sides.remove(other)
    assert asked.wait() in ([], [('error', b'Timeout')])
    assert watch.wait(2)[1] == ('there', None)
    assert one.present('there') == set()


@MAKES
def test_peers_meet_and_talk_directly(
    makes: tuple[type[Side], type[Side]], router: str, sides: list[Side]
) -> None:
    hub = sides[0]
    one, other = (make('peer', listen=('tcp/127.0.0.1:0',), connect=(router,)) for make in makes)  # type: ignore[call-arg]
    sides += [one, other]
    wait_for(lambda: other.id in one.links() and one.id in other.links(), 'the link')
    hub.close()
    sides.remove(hub)
    heard = other.subscribe('a')
    other.token('ready')
    one.watch('ready').wait(1)
    one.put('a', b'x')
    assert heard.wait(1) == [('a', b'x')]


def test_three_of_several_servers_answer_a_query_for_all_complete_ones(
    router: str, sides: list[Side]
) -> None:
    servers = [Theirs('client', connect=(router,)), *(Ours('client', connect=(router,)) for _ in range(3))]
    asker = Ours('client', connect=(router,))
    sides += [*servers, asker]
    for number, server in enumerate(servers):
        server.serve('q', b'%d' % number, complete=number != 3)
        server.token(f'up/{number}')
    asker.watch('up/*').wait(4)
    answers = {payload for _, payload in asker.ask('q').wait()}
    assert answers == {b'0', b'1', b'2'}


def test_a_client_that_goes_leaves_no_query_behind(router: str, sides: list[Side]) -> None:
    hub = sides[0]
    assert isinstance(hub, Ours)
    server, asker = Ours('client', connect=(router,)), Ours('client', connect=(router,))
    sides += [server, asker]
    server.serve('slow', None)
    server.token('up')
    asker.watch('up').wait(1)
    asker.ask('slow', timeout_s=60.0)
    wait_for(lambda: server.held, 'the query')
    asker.close()
    sides.remove(asker)
    wait_for(lambda: not hub.protocol.queries.pending, 'the router to forget')
