"""Floods of small messages between sessions arrive whole and in order, whatever their publisher does next."""

from __future__ import annotations

import threading
from collections.abc import Iterator

import pytest
from helpers.patience import PATIENCE, wait_for
from helpers.zenoh_sides import Ours, Side, Theirs, address

from goalwire.zenoh.io.socket_link import READ_SIZE, SocketLink
from goalwire.zenoh.protocol.publication import FLOOD

COUNT = 5 * FLOOD


@pytest.fixture(params=[Ours, Theirs])
def sides(request: pytest.FixtureRequest) -> Iterator[tuple[Ours, Side]]:
    """One of ours that listens, and one of either make that is linked to it."""
    where = address()
    ours = Ours('peer', listen=(where,))
    other = request.param('peer', connect=(where,))
    yield ours, other
    other.close()
    ours.close()


def meet(ours: Ours, key: str) -> None:
    """Wait until the other side's subscriber is known."""
    wait_for(
        lambda: any(each.peer.subscribers.has_meeting(key) for each in ours.protocol.links), 'its subscriber'
    )


def flood(ours: Ours, first: int, count: int) -> None:
    """Put numbers; the last of them are held back."""
    ours.protocol.stamps.burst = 2 * FLOOD
    for number in range(first, first + count):
        ours.put('k', b'%d' % number)


def test_the_last_of_a_flood_arrives_though_nothing_follows(sides: tuple[Ours, Side]) -> None:
    ours, other = sides
    heard = other.subscribe('k')
    meet(ours, 'k')
    flood(ours, 0, COUNT)
    heard.wait(COUNT)
    assert [payload for _, payload in heard.samples] == [b'%d' % number for number in range(COUNT)]
    flood(ours, COUNT, 1)  # and again, when whoever sees to that sleeps
    heard.wait(COUNT + 1)


def wait(gate: threading.Event) -> None:
    """Hold the thread that reads until the gate opens."""
    assert gate.wait(PATIENCE)


def test_callbacks_run_before_more_than_one_piece_of_a_flood_is_read(monkeypatch: pytest.MonkeyPatch) -> None:
    """Else a subscription that keeps a thousand messages would lose the others of what was read at once."""
    where, read = address(), SocketLink._read
    turns: list[int] = []

    def counted(link: SocketLink) -> None:
        before = len(heard.samples)
        read(link)
        turns.append(len(heard.samples) - before)

    monkeypatch.setattr(SocketLink, '_read', counted)
    ours = Ours('peer', listen=(where,))
    other = Ours('peer', connect=(where,))
    heard = other.subscribe('k')
    meet(ours, 'k')
    gate = threading.Event()
    other.session._poller.call(lambda: wait(gate))  # nothing is read until all waits
    for _ in range(10_000):
        ours.put('k', bytes(90))
    gate.set()
    heard.wait(10_000)
    assert max(turns) <= READ_SIZE // 90 + 1
    other.close()
    ours.close()


def test_a_flood_of_several_threads_arrives_whole_and_each_in_order(sides: tuple[Ours, Side]) -> None:
    ours, other = sides
    heard = [other.subscribe(f'k{at}') for at in range(3)]
    for at in range(3):
        meet(ours, f'k{at}')
    ours.protocol.stamps.burst = 2 * FLOOD

    def publish(at: int) -> None:
        for number in range(1000):
            ours.put(f'k{at}', b'%d' % number)

    threads = [threading.Thread(target=publish, args=(at,)) for at in range(3)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join(PATIENCE)
        assert not thread.is_alive()
    for each in heard:
        each.wait(1000)
        assert [payload for _, payload in each.samples] == [b'%d' % number for number in range(1000)]


def test_what_is_held_back_goes_out_before_its_session_closes() -> None:
    where = address()
    other = Ours('peer', listen=(where,))
    heard = other.subscribe('k')
    ours = Ours('peer', connect=(where,))
    meet(ours, 'k')
    flood(ours, 0, COUNT)
    ours.close()
    heard.wait(COUNT)
    other.close()
    assert not [thread for thread in threading.enumerate() if ours.id[:8] in thread.name]
