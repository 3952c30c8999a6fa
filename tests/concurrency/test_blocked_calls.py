"""Threads that block until a session has changed."""

from __future__ import annotations

import threading
from collections.abc import Iterator

import pytest
from helpers.patience import PATIENCE

from goalwire.concurrency.blocked_calls import BlockedCalls
from goalwire.concurrency.leader_followers import LeaderFollowers
from goalwire.concurrency.poller import Poller


@pytest.fixture
def blocked_calls() -> Iterator[BlockedCalls]:
    """Blocked calls on a wire to which nothing comes."""
    poller = Poller('quiet wire')
    wire_poller = LeaderFollowers(poller, 'quiet wire')
    wire_poller.start()
    yield BlockedCalls(wire_poller)
    wire_poller.close()
    poller.close()


def test_what_holds_already_is_not_waited_for(blocked_calls: BlockedCalls) -> None:
    assert blocked_calls.wait_until(lambda: True, 0)


def test_time_passes_in_vain_if_nothing_changes(blocked_calls: BlockedCalls) -> None:
    assert not blocked_calls.wait_until(lambda: False, 0.01)


def test_each_waiter_looks_again_when_all_are_woken(blocked_calls: BlockedCalls) -> None:
    looked = [threading.Event() for _ in range(3)]
    has_changed: list[bool] = []
    results: list[bool] = []

    def wait(event: threading.Event) -> None:
        def condition() -> bool:
            event.set()
            return bool(has_changed)

        results.append(blocked_calls.wait_until(condition, 2 * PATIENCE))

    threads = [threading.Thread(target=wait, args=(event,)) for event in looked]
    for thread in threads:
        thread.start()
    assert all(event.wait(PATIENCE) for event in looked)
    has_changed.append(True)
    blocked_calls.wake_all()
    for thread in threads:
        thread.join(PATIENCE)
        assert not thread.is_alive(), 'it was not woken'
    assert results == [True] * 3
