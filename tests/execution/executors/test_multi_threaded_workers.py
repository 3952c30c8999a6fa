"""Which threads of a MultiThreadedExecutor a spin wakes, and that no work is left without one."""

from __future__ import annotations

import socket
import sys
import threading
from collections.abc import Callable, Iterator
from functools import partial
from pathlib import Path
from queue import SimpleQueue
from select import POLLIN
from types import SimpleNamespace
from typing import Any, cast

import pytest
from helpers.collector import Collector
from helpers.execution import SmallContext, SmallNode, Spinning
from helpers.patience import PATIENCE, soon, wait_for

from goalwire.concurrency.leader_followers import LeaderFollowers
from goalwire.concurrency.poller import Poller
from goalwire.execution.callback_groups import ReentrantCallbackGroup
from goalwire.execution.event_queue import EventQueue
from goalwire.execution.executors.multi_threaded import MultiThreadedExecutor
from goalwire.execution.future import Future
from goalwire.execution.time.clock import Clock
from goalwire.execution.time.timer import Timer
from goalwire.execution.waiters import LockWaiter, WireWaiter
from goalwire.rules.time import ClockType
from goalwire.transport.contract import Session

SPINS = 200


def _sleep(executor: MultiThreadedExecutor, number: int) -> bool:
    return executor._ready.sleepers == number


def sleeps_of_workers() -> int:
    """Return how often the threads of executors have gone to sleep until now."""
    count = 0
    for thread in threading.enumerate():
        if thread.name == 'goalwire-callbacks':
            status = Path(f'/proc/self/task/{thread.native_id}/status').read_text(encoding='ascii')
            count += int(status.split('\nvoluntary_ctxt_switches:')[1].split()[0])
    return count


def run_once(executor: MultiThreadedExecutor, node: SmallNode) -> None:
    """Spin until a worker has run a callback, so that a worker sleeps in the executor."""
    done: Future[None] = Future()
    EventQueue(node.work_queue, None, done.set_result).deliver(None)
    executor.spin_until_future_complete(done, PATIENCE)
    assert done.done()


class TellsOfSleep(MultiThreadedExecutor):
    """Tells of the first sleep of each `spin_once`."""

    def __init__(self, context: SmallContext) -> None:
        super().__init__(4, context=context)
        self.asleep: Collector[str] = Collector()

    def _new_waiter(self) -> WireWaiter:
        asleep, thread = self.asleep, threading.current_thread().name

        class Telling(WireWaiter):
            is_first = True

            def wait(self, timeout_ns: int | None = None) -> bool:
                if self.is_first:
                    self.is_first = False
                    asleep(thread)
                return super().wait(timeout_ns)

        if thread == 'spinning':
            return Telling(self._shutdown_signal, self._fd_selector)
        return super()._new_waiter()


@pytest.fixture
def telling(context: SmallContext, node: SmallNode) -> Iterator[TellsOfSleep]:
    with TellsOfSleep(context) as executor:
        executor.add_node(node)
        yield executor


@pytest.mark.skipif(sys.platform != 'linux', reason='other systems do not count the sleeps of a thread')
def test_a_spin_for_a_future_wakes_no_worker(multi: MultiThreadedExecutor, node: SmallNode) -> None:
    multi.add_node(node)
    run_once(multi, node)
    asked: SimpleQueue[Future[None] | None] = SimpleQueue()

    def answer() -> None:
        while (future := asked.get()) is not None:
            future.set_result(None)

    thread = threading.Thread(target=answer)
    thread.start()
    before = sleeps_of_workers()
    for _ in range(SPINS):
        future: Future[None] = Future()
        asked.put(future)
        multi.spin_until_future_complete(future, PATIENCE)
        assert future.done()
    woken = sleeps_of_workers() - before
    asked.put(None)
    thread.join()
    assert woken < SPINS / 4


class Wire:
    """A wire of one socket pair. Each byte that is sent is given to `receive` by the thread that reads it.

    It has no thread of its own, so only threads of the executor read.
    """

    def __init__(self, context: SmallContext) -> None:
        self.readers: list[int] = []
        self.receive: Callable[[], object] = bool
        self._poller = Poller('wire')
        self._wire_poller = LeaderFollowers(self._poller, 'wire')
        self._here, self._there = socket.socketpair()
        self._poller.register(self._here.fileno(), POLLIN, self._read)
        session = SimpleNamespace(wire_poller=self._wire_poller, silence=lambda: None)
        context.shutdown_signal.take_session(cast('Session', session))

    def send(self) -> None:
        self._there.send(b'.')

    def _read(self, _: int) -> None:
        self._here.recv(1)
        self.readers.append(threading.get_ident())
        self.receive()

    def close(self) -> None:
        self._wire_poller.close()
        self._poller.close()
        self._here.close()
        self._there.close()


@pytest.fixture
def wire(context: SmallContext) -> Iterator[Wire]:
    wire = Wire(context)
    yield wire
    wire.close()


def test_a_spin_for_a_future_reads_the_wire_itself(
    multi: MultiThreadedExecutor, node: SmallNode, wire: Wire
) -> None:
    multi.add_node(node)
    run_once(multi, node)
    spinning_threads: list[int] = []

    def spin() -> None:
        spinning_threads.append(threading.get_ident())
        for _ in range(3):
            future: Future[None] = Future()
            wire.receive = partial(future.set_result, None)
            wire.send()
            multi.spin_until_future_complete(future, PATIENCE)

    with Spinning(multi, spin) as spinning:
        assert soon(spinning.ended)
    assert wire.readers == spinning_threads * 3


def test_workers_read_the_wire_if_a_spin_brings_many_callbacks(
    multi: MultiThreadedExecutor, node: SmallNode, wire: Wire
) -> None:
    multi.add_node(node)
    run_once(multi, node)
    got: Collector[int] = Collector()
    event_queue: EventQueue[int] = EventQueue(node.work_queue, None, got)
    wire.receive = partial(event_queue.deliver, 1)
    future: Future[None] = Future()
    spinning_threads: list[int] = []

    def spin() -> None:
        spinning_threads.append(threading.get_ident())
        multi.spin_until_future_complete(future, PATIENCE)

    with Spinning(multi, spin) as spinning:
        for number in range(1, 41):
            wire.send()
            got.expect(number)
        future.set_result(None)
        assert soon(spinning.ended)
    assert wire.readers[0] == spinning_threads[0]
    assert spinning_threads[0] not in wire.readers[-20:]


def test_work_that_comes_between_two_spins_is_run_by_the_next(
    multi: MultiThreadedExecutor, node: SmallNode
) -> None:
    multi.add_node(node)
    for number in range(SPINS):
        run_once(multi, node)
        got: list[int] = []
        done: Future[None] = Future()
        event_queue: EventQueue[int] = EventQueue(node.work_queue, None, got.append)
        event_queue.deliver(number)
        last: EventQueue[None] = EventQueue(node.work_queue, None, done.set_result)
        last.deliver(None)
        multi.spin_until_future_complete(done, PATIENCE)
        assert done.done()
        assert got == [number]


def test_spin_once_finds_its_work_although_workers_sleep_there_too(
    telling: TellsOfSleep, node: SmallNode
) -> None:
    got: Collector[int] = Collector()
    event_queue: EventQueue[int] = EventQueue(node.work_queue, None, got)

    def spin() -> None:
        for _ in range(SPINS):
            run_once(telling, node)
            telling.spin_once(PATIENCE)

    with Spinning(telling, spin) as spinning:
        for number in range(1, SPINS + 1):
            telling.asleep.expect(number)
            event_queue.deliver(number)
            got.expect(number)
        assert soon(spinning.ended)


def test_two_threads_in_spin_once_do_not_take_each_others_wake_up(
    telling: TellsOfSleep, node: SmallNode
) -> None:
    got: Collector[int] = Collector()
    event_queue: EventQueue[int] = EventQueue(node.work_queue, ReentrantCallbackGroup(), got)
    with (
        Spinning(telling, lambda: telling.spin_once(PATIENCE)) as one,
        Spinning(telling, lambda: telling.spin_once(PATIENCE)) as two,
    ):
        telling.asleep.expect(2)
        event_queue.deliver(1)
        got.expect(1)
        event_queue.deliver(2)
        got.expect(2)
        assert soon(one.ended)
        assert soon(two.ended)


def test_an_earlier_timer_reaches_a_spin_once_although_a_worker_watches_the_timers(
    telling: TellsOfSleep, node: SmallNode
) -> None:
    clock = Clock(clock_type=ClockType.STEADY_TIME)
    late = Timer(lambda: None, None, 10**15, clock, work_queue=node.work_queue)
    run_once(telling, node)
    got: Collector[Any] = Collector()
    with Spinning(telling, lambda: telling.spin_once(PATIENCE)) as spinning:
        telling.asleep.expect(1)
        early = Timer(lambda: got(None), None, 1000, clock, work_queue=node.work_queue)
        got.expect(1, PATIENCE / 2)
        assert soon(spinning.ended)
        early.destroy()
    late.destroy()


def test_an_endless_spin_beside_one_for_a_future_runs_the_work_of_both(
    multi: MultiThreadedExecutor, node: SmallNode
) -> None:
    multi.add_node(node)
    run_once(multi, node)
    got: Collector[int] = Collector()
    event_queue: EventQueue[int] = EventQueue(node.work_queue, ReentrantCallbackGroup(), got)
    ended: Future[None] = Future()
    waiting = threading.Thread(target=multi.spin_until_future_complete, args=(ended, PATIENCE))
    with Spinning(multi) as endless:
        waiting.start()
        for number in range(1, 4):
            event_queue.deliver(number)
            got.expect(number)
        ended.set_result(None)
        waiting.join(PATIENCE)
        assert not waiting.is_alive()
        event_queue.deliver(4)
        got.expect(4)
        assert not endless.ended.is_set()


class Late(MultiThreadedExecutor):
    """A spin that has found its future done goes on after the worker has ended its callback."""

    def __init__(self, context: SmallContext) -> None:
        super().__init__(4, context=context)
        self.future: Future[None] = Future()
        self.looked = threading.Event()
        self.idle = threading.Event()

    def _raise_failure(self) -> None:
        super()._raise_failure()
        if self.future.done() and not self.looked.is_set():
            self.looked.set()
            assert soon(self.idle)

    def _sleep_at_queue(self, waiter: WireWaiter, on_lock: LockWaiter) -> None:
        if self.looked.is_set():
            self.idle.set()
        super()._sleep_at_queue(waiter, on_lock)


def test_a_spin_raises_the_error_of_the_callback_that_has_completed_its_future(
    context: SmallContext, node: SmallNode
) -> None:
    with Late(context) as executor:
        executor.add_node(node)

        def complete(_: None) -> None:
            executor.future.set_result(None)
            assert soon(executor.looked)
            raise ValueError('just afterwards')

        event_queue: EventQueue[None] = EventQueue(node.work_queue, None, complete)
        event_queue.deliver(None)
        with pytest.raises(ValueError, match='just afterwards'):
            executor.spin_until_future_complete(executor.future, PATIENCE)


class Paused(MultiThreadedExecutor):
    """Its worker gets work as soon as it sleeps; when that has woken it, the spin ends before it goes on."""

    def __init__(self, context: SmallContext) -> None:
        super().__init__(4, context=context)
        self.deliver: Callable[[], object] = bool
        self.go_on = threading.Event()

    def _is_misplaced(self) -> bool:
        deliver, self.deliver = self.deliver, bool
        deliver()
        return super()._is_misplaced()

    def _sleep_at_queue(self, waiter: WireWaiter, on_lock: LockWaiter) -> None:
        super()._sleep_at_queue(waiter, on_lock)
        if not self.go_on.is_set():
            self._fail(ValueError('the spin is over'))
            assert soon(self.go_on)


def test_work_that_woke_a_worker_as_the_spin_ended_reaches_a_spin_once(
    context: SmallContext, node: SmallNode
) -> None:
    with Paused(context) as executor:
        executor.add_node(node)
        got: Collector[int] = Collector()
        event_queue: EventQueue[int] = EventQueue(node.work_queue, None, got)
        with Spinning(executor, executor.spin_once) as once:
            wait_for(lambda: executor._ready.sleepers == 1, 'spin_once to sleep')
            executor.deliver = partial(event_queue.deliver, 1)
            with pytest.raises(ValueError, match='is over'):
                executor.spin_until_future_complete(Future(), PATIENCE)
            executor.go_on.set()
            got.expect(1)
            assert soon(once.ended)


def test_a_long_callback_does_not_keep_the_other_workers_from_the_wire(
    multi: MultiThreadedExecutor, node: SmallNode, wire: Wire
) -> None:
    multi.add_node(node)
    group = ReentrantCallbackGroup()
    got: Collector[int] = Collector()
    quick: EventQueue[int] = EventQueue(node.work_queue, group, got)
    future: Future[None] = Future()
    waits, answered = threading.Event(), threading.Event()

    def wait(_: None) -> None:
        waits.set()
        assert answered.wait(PATIENCE / 2)

    slow: EventQueue[None] = EventQueue(node.work_queue, group, wait)
    with Spinning(multi, lambda: multi.spin_until_future_complete(future, PATIENCE)) as spinning:
        wire.receive = partial(quick.deliver, 1)
        for number in range(1, 21):
            wire.send()
            got.expect(number)
        wire.receive = partial(slow.deliver, None)
        wire.send()
        assert soon(waits)
        wire.receive = answered.set
        wire.send()
        assert soon(answered)
        future.set_result(None)
        assert soon(spinning.ended)
    assert spinning.error is None


def test_a_spin_inside_a_callback_leaves_a_worker_at_the_queue_when_it_ends(
    context: SmallContext, node: SmallNode
) -> None:
    group = ReentrantCallbackGroup()
    begun: Collector[str] = Collector()
    go_on = {name: threading.Event() for name in ('first', 'second', 'third', 'outer')}
    inner: Future[None] = Future()
    inner_threads: list[int] = []

    def run(name: str) -> None:
        if name == 'outer':
            inner_threads.append(threading.get_ident())
            executor.spin_until_future_complete(inner, PATIENCE)
        begun(name)
        assert name == 'last' or soon(go_on[name])

    with MultiThreadedExecutor(2, context=context) as executor:
        executor.add_node(node)
        events: EventQueue[str] = EventQueue(node.work_queue, group, run)
        with Spinning(executor) as spinning:
            events.deliver('outer')
            wait_for(partial(_sleep, executor, 2), 'the inner spin and the other worker to sleep')
            for number, name in enumerate(('first', 'second'), 1):
                events.deliver(name)
                begun.expect(number)
            # The inner spin falls asleep first, so that the next event wakes the other worker.
            is_first = begun.threads[0] == inner_threads[0]
            for number, name in enumerate(('first', 'second') if is_first else ('second', 'first'), 1):
                go_on[name].set()
                wait_for(partial(_sleep, executor, number), 'it to sleep')
            executor._pool.raise_limit(1)
            events.deliver('third')
            begun.expect(3)
            assert begun.threads[2] not in inner_threads
            inner.set_result(None)
            begun.expect(4)
            events.deliver('last')  # while both workers are in callbacks that wait for it
            begun.expect(5, PATIENCE / 2)
            for event in go_on.values():
                event.set()
        assert spinning.error is None


def test_a_spin_whose_worker_cannot_start_is_over(
    multi: MultiThreadedExecutor, monkeypatch: pytest.MonkeyPatch
) -> None:
    def refuse(_: threading.Thread) -> None:
        raise RuntimeError("can't start new thread")

    with monkeypatch.context() as patch:
        patch.setattr(threading.Thread, 'start', refuse)
        with pytest.raises(RuntimeError, match='new thread'):
            multi.spin_until_future_complete(Future(), PATIENCE)
    assert not multi.is_driven()
    assert len(multi._pool) == 0
