from __future__ import annotations

import gc
import os
import subprocess
import sys
import threading
from types import FrameType
from weakref import ref

import pytest
from helpers.patience import PATIENCE

from goalwire.execution.asyncio.fd_selector import FdSelector
from goalwire.execution.shutdown_signal import ShutdownSignal
from goalwire.execution.time.steady_clock import STEADY, deadline_after
from goalwire.execution.waiters import Waiter, WireWaiter
from goalwire.weak_members import WeakMembers


def test_a_wake_that_comes_first_ends_the_next_wait_at_once() -> None:
    waiter = Waiter()
    waiter.wake()
    assert waiter.wait(int(PATIENCE * 1e9))


def test_several_wakes_count_as_one() -> None:
    waiter = Waiter()
    waiter.wake()
    waiter.wake()
    assert waiter.wait(int(PATIENCE * 1e9))
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


def test_it_ends_once_and_tells_everybody_once() -> None:
    shutdown_signal = ShutdownSignal()
    told: list[str] = []
    shutdown_signal.watch(lambda: told.append('a'))
    shutdown_signal.watch(lambda: told.append('b'))
    assert (shutdown_signal.alive, shutdown_signal.reason) == (True, None)
    assert shutdown_signal.end('shutdown')
    assert not shutdown_signal.end('again')
    assert (shutdown_signal.alive, shutdown_signal.reason) == (False, 'shutdown')
    assert sorted(told) == ['a', 'b']


def test_who_watches_too_late_is_told_at_once() -> None:
    shutdown_signal = ShutdownSignal()
    shutdown_signal.end('over')
    told: list[str] = []
    shutdown_signal.watch(lambda: told.append('a'))
    assert told == ['a']


def test_a_closed_watch_is_not_told() -> None:
    shutdown_signal = ShutdownSignal()
    told: list[str] = []
    watch = shutdown_signal.watch(lambda: told.append('a'))
    watch.close()
    watch.close()
    shutdown_signal.end('over')
    assert told == []


def test_nobody_is_missed_who_begins_to_watch_while_it_ends() -> None:
    for _ in range(500):
        shutdown_signal = ShutdownSignal()
        told = threading.Semaphore(0)
        both = threading.Barrier(2, timeout=PATIENCE)

        def end(shutdown_signal: ShutdownSignal = shutdown_signal, both: threading.Barrier = both) -> None:
            both.wait()
            shutdown_signal.end('over')

        thread = threading.Thread(target=end)
        thread.start()
        both.wait()
        shutdown_signal.watch(told.release)
        thread.join()
        assert told.acquire(timeout=10)
        assert not told.acquire(blocking=False)


def test_the_end_wakes_every_waiter_for_all_of_its_life() -> None:
    shutdown_signal = ShutdownSignal()
    waiters = [shutdown_signal.new_waiter() for _ in range(2)]
    for waiter in waiters:
        waiter.wake()
        assert waiter.wait(0)
    shutdown_signal.end('over')
    assert all(waiter.wait(0) for waiter in waiters)


def test_a_waiter_is_not_kept_by_the_lifeline_that_wakes_it() -> None:
    shutdown_signal = ShutdownSignal()
    forgotten = ref(shutdown_signal.new_waiter())
    assert forgotten() is None
    shutdown_signal.end('over')


@pytest.mark.parametrize('allocations', range(1, 12))
def test_garbage_that_is_collected_while_it_ends_keeps_nobody_asleep(allocations: int) -> None:
    shutdown_signal = ShutdownSignal()
    gc.collect()
    before = gc.get_threshold()
    gc.disable()
    try:
        for _ in range(40):
            garbage = WireWaiter(shutdown_signal)
            garbage.interrupt = garbage.wake  # a circle
        del garbage
        waiter = shutdown_signal.new_waiter()
        gc.set_threshold(gc.get_count()[0] + allocations)
        gc.enable()
        assert shutdown_signal.end('over')
    finally:
        gc.set_threshold(*before)
        gc.enable()
    assert waiter.wait(0)


WITHOUT_GIL = """
import sys

sys._is_gil_enabled = lambda: {enabled}
import rclpy

rclpy.init()
rclpy.create_node('free').create_publisher(__import__('std_msgs.msg').msg.String, 'chatter', 1)
print('open')
rclpy.shutdown()
"""


@pytest.mark.parametrize(
    ('enabled', 'options', 'output', 'warns'),
    [
        (True, (), 'open', False),
        (False, (), 'open', True),
        (False, ('-W', 'error::RuntimeWarning'), '', True),
    ],
)
def test_a_python_without_a_gil_is_warned_about(
    enabled: bool, options: tuple[str, ...], output: str, warns: bool
) -> None:
    result = subprocess.run(
        [sys.executable, *options, '-c', WITHOUT_GIL.replace('{enabled}', str(enabled))],
        env=os.environ | {'RMW_IMPLEMENTATION': 'goalwire_memory'},
        capture_output=True,
        text=True,
        timeout=PATIENCE * 5,
        check=False,
    )
    assert result.stdout.strip() == output, result.stderr
    assert ('RuntimeWarning: this Python runs without its global interpreter lock' in result.stderr) is warns
    assert ('PYTHON_GIL=1' in result.stderr) is warns


def test_listeners_are_held_weakly_and_told_in_order() -> None:
    class Listener:
        pass

    listeners = WeakMembers[Listener]()
    first, second = Listener(), Listener()
    listeners.add(first)
    listeners.add(second)
    listeners.add(first)
    assert listeners.alive() == [first, second]
    listeners.discard(second)
    listeners.discard(second)
    assert listeners.alive() == [first]
    del first
    gc.collect()
    assert listeners.alive() == []
    assert not listeners


def test_no_step_of_python_runs_when_a_listener_dies() -> None:
    """A signal's handler can raise in such a step. Python would print the KeyboardInterrupt and lose it."""

    class Listener:
        pass

    entered: list[str] = []

    def note(frame: FrameType, event: str, _: object) -> None:
        if event == 'call':
            entered.append(frame.f_code.co_qualname)

    listeners = WeakMembers[Listener]()
    listener = Listener()
    listeners.add(listener)
    before = sys.getprofile()
    sys.setprofile(note)
    del listener
    sys.setprofile(before)
    assert entered == []
    assert listeners.alive() == []


def test_a_listener_may_leave_while_others_are_told() -> None:
    class Leaver:
        def told(self) -> None:
            listeners.discard(self)
            listeners.add(late)

    listeners = WeakMembers[Leaver]()
    leavers, late = [Leaver() for _ in range(3)], Leaver()
    for leaver in leavers:
        listeners.add(leaver)
    for leaver in listeners.alive():
        leaver.told()
    assert listeners.alive() == [late]
