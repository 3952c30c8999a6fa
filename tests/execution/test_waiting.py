from __future__ import annotations

import threading

import pytest
from helpers.patience import PATIENCE

from goalwire.execution.fd_selector import FdSelector
from goalwire.execution.monotonic import STEADY, deadline_after
from goalwire.execution.waiting import ShutdownSignal, Waiter, WireWaiter


def test_a_wake_that_comes_first_ends_the_next_wait_at_once() -> None:
    waiter = Waiter()
    waiter.wake()
    assert waiter.wait()


def test_several_wakes_count_as_one() -> None:
    waiter = Waiter()
    waiter.wake()
    waiter.wake()
    assert waiter.wait(0)
    assert not waiter.wait(0)


def test_a_wait_ends_at_its_timeout() -> None:
    begun = STEADY.now()
    assert not Waiter().wait(20_000_000)
    assert STEADY.now() - begun >= 20_000_000


def test_another_thread_wakes() -> None:
    waiter = Waiter()
    threading.Thread(target=waiter.wake).start()
    assert waiter.wait(int(PATIENCE * 1e9))


def test_a_timeout_that_is_past_looks_once() -> None:
    waiter = Waiter()
    assert not waiter.wait(-5)
    waiter.wake()
    assert waiter.wait(-5)


def test_the_steady_clock_waits_until_a_deadline_and_no_longer() -> None:
    deadline = STEADY.now() + 10_000_000
    assert not STEADY.wait(Waiter(), deadline)
    assert STEADY.now() >= deadline


def test_no_timeout_a_negative_one_and_an_infinite_one_mean_no_limit() -> None:
    assert deadline_after(STEADY, None) is None
    assert deadline_after(STEADY, -1.0) is None
    infinite = deadline_after(STEADY, float('inf'))
    assert infinite is not None
    assert infinite > STEADY.now() + 10**18


def test_a_signal_that_comes_as_a_sleep_beside_the_wire_begins_leaves_nobody_depending() -> None:
    class Interrupted(ShutdownSignal):
        """Python runs a signal's handler after calls, and Ctrl-C's raises."""

        __slots__ = ()

        def add_external_sleeper(self, who: object) -> None:
            super().add_external_sleeper(who)
            raise KeyboardInterrupt

    shutdown_signal, fd_selector = Interrupted(), FdSelector(lambda: None)
    wire_waiter, waiter = WireWaiter(shutdown_signal), WireWaiter(shutdown_signal, fd_selector)
    with pytest.raises(KeyboardInterrupt):
        wire_waiter._wait_on_lock_beside_wire(0)
    with pytest.raises(KeyboardInterrupt):
        waiter._wait_on_descriptors(fd_selector, 0)
    assert not shutdown_signal.external_sleepers
    assert waiter.interrupt is None
