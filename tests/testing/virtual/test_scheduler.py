"""The scheduler without any stand-in: whose turn it is, and how far time jumps."""

from __future__ import annotations

import threading
from collections.abc import Callable

import pytest
from helpers.patience import PATIENCE

from goalwire.errors import DeadlockError
from goalwire.testing.virtual.scheduler import Child, Scheduler, never


def _scheduler() -> tuple[Scheduler, Child]:
    scheduler = Scheduler(threading.current_thread(), 0)
    here = scheduler.here()
    assert here is not None
    return scheduler, here


def _start(scheduler: Scheduler, play: Callable[[Child], object]) -> threading.Thread:
    """Start a thread that is a member."""

    def run() -> None:
        scheduler.begin(child)
        try:
            play(child)
        finally:
            scheduler.end(child)

    thread = threading.Thread(target=run)
    child = scheduler.enrol(thread)
    thread.start()
    return thread


def test_time_jumps_to_the_earliest_deadline() -> None:
    scheduler, here = _scheduler()
    assert scheduler.wait(here, never, 700) is False
    assert scheduler.now == 700


def test_what_is_there_is_taken_before_time_passes() -> None:
    scheduler, here = _scheduler()
    assert scheduler.wait(here, lambda: True, 700) is True
    assert scheduler.now == 0


def test_of_several_that_can_go_on_the_one_that_waits_longest_does() -> None:
    scheduler, here = _scheduler()
    order: list[str] = []
    threads = []
    for name in 'abc':

        def play(child: Child, name: str = name) -> None:
            for _ in range(3):
                order.append(name)
                scheduler.wait(child, lambda: True, None)

        threads.append(_start(scheduler, play))
    scheduler.wait(here, lambda: len(order) == 9, None)
    assert ''.join(order) == 'abcabcabc'
    while scheduler.wait(here, lambda: True, None) and any(thread.is_alive() for thread in threads):
        pass
    for thread in threads:
        thread.join(PATIENCE)


def test_nobody_waits_for_a_thread_that_has_ended() -> None:
    scheduler, here = _scheduler()
    thread = _start(scheduler, lambda child: None)
    assert scheduler.wait(here, never, 50) is False
    thread.join(PATIENCE)
    assert scheduler.now == 50


def test_a_thread_that_could_not_be_started_is_waited_for_no_more() -> None:
    scheduler, here = _scheduler()
    scheduler.strike(scheduler.enrol(threading.Thread()))
    assert scheduler.wait(here, never, 50) is False


def test_where_nothing_is_due_a_wait_for_the_real_world_goes_on_there() -> None:
    scheduler, here = _scheduler()
    assert scheduler.wait(here, never, None, outside=True) is None
    assert scheduler.wait(here, never, 10, outside=True) is False


def test_where_nothing_is_due_the_owner_is_told_and_may_wait_again() -> None:
    scheduler, here = _scheduler()
    for _ in range(2):
        with pytest.raises(DeadlockError, match='nothing is due'):
            scheduler.wait(here, never, None)
    assert scheduler.wait(here, never, 5) is False


def test_a_signal_handler_that_raises_ends_a_wait_and_leaves_the_order_whole() -> None:
    scheduler, here = _scheduler()

    class Interrupted:
        """A gate at which the handler's error comes out."""

        def acquire(self, *, timeout: float) -> bool:
            raise KeyboardInterrupt

        def release(self) -> None:
            raise AssertionError('nobody was to wake this thread')

    other = scheduler.enrol(threading.Thread())
    here.gate, gate = Interrupted(), here.gate  # type: ignore[assignment]
    with pytest.raises(KeyboardInterrupt):
        scheduler.wait(here, never, 100)
    here.gate = gate
    scheduler.strike(other)


def test_the_end_lets_everyone_go_on_in_real_time() -> None:
    scheduler, here = _scheduler()
    outcomes: list[bool | None] = []
    thread = _start(scheduler, lambda child: outcomes.append(scheduler.wait(child, never, 900)))
    assert scheduler.wait(here, never, 10) is False
    scheduler.close()
    thread.join(PATIENCE)
    assert outcomes == [None]
    assert scheduler.here() is None
    assert scheduler.wait(here, never, 900) is None


def test_who_reads_the_time_again_and_again_lets_some_pass() -> None:
    scheduler, here = _scheduler()
    reads = 0
    while scheduler.read(here) < 1_000_000_000:
        reads += 1
    assert 1000 < reads < 200_000


def test_a_thread_that_blocks_in_the_real_world_is_named_after_a_while(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr('goalwire.testing.virtual.scheduler._STALL_S', 0.05)
    scheduler, here = _scheduler()
    real = threading.Event()

    def block_for_real(child: Child) -> None:
        real.wait(PATIENCE)

    thread = _start(scheduler, block_for_real)
    with pytest.raises(DeadlockError, match=r'stood still for 0\.1 s(.|\n)*in block_for_real'):
        scheduler.wait(here, never, 100)
    real.set()
    thread.join(PATIENCE)
    assert scheduler.wait(here, never, 100) is False
