from __future__ import annotations

import os
import selectors
import threading
from collections.abc import Iterator

import pytest
from helpers.patience import PATIENCE, wait_for

from goalwire.execution.asyncio.fd_selector import FdSelector
from goalwire.execution.shutdown_signal import ShutdownSignal
from goalwire.execution.waiters import WireWaiter

READ = selectors.EVENT_READ
LONG = int(PATIENCE * 1e9)


class Pipe:
    def __init__(self) -> None:
        self.reader, self.writer = os.pipe()

    def write(self) -> None:
        os.write(self.writer, b'x')


@pytest.fixture
def pipe() -> Iterator[Pipe]:
    pipe = Pipe()
    yield pipe
    os.close(pipe.reader)
    os.close(pipe.writer)


@pytest.fixture
def fd_selector() -> Iterator[FdSelector]:
    fd_selector = FdSelector(lambda: None)
    yield fd_selector
    fd_selector.close()


def test_a_ready_descriptor_is_reported_once_until_it_is_armed_again(
    fd_selector: FdSelector, pipe: Pipe
) -> None:
    reports: list[tuple[int, int]] = []
    fd_selector.arm(pipe.reader, READ, lambda fd, events: reports.append((fd, events)))
    fd_selector.poll()
    assert reports == []
    pipe.write()
    fd_selector.poll()
    fd_selector.poll()
    assert reports == [(pipe.reader, READ)]
    assert fd_selector.watched == 0
    fd_selector.arm(pipe.reader, READ, lambda fd, events: reports.append((fd, events)))
    fd_selector.poll()
    assert len(reports) == 2


def test_a_disarmed_descriptor_is_not_reported(fd_selector: FdSelector, pipe: Pipe) -> None:
    reports: list[int] = []
    fd_selector.arm(pipe.reader, READ, lambda fd, _: reports.append(fd))
    fd_selector.disarm(pipe.reader)
    fd_selector.disarm(pipe.reader)
    pipe.write()
    fd_selector.poll()
    assert reports == []


def test_a_parked_thread_wakes_for_a_descriptor(fd_selector: FdSelector, pipe: Pipe) -> None:
    reports: list[int] = []
    fd_selector.arm(pipe.reader, READ, lambda fd, _: reports.append(fd))
    writer = threading.Timer(0.02, pipe.write)
    writer.start()
    WireWaiter(ShutdownSignal(), fd_selector).wait(LONG)
    assert reports == [pipe.reader]
    writer.join()


def test_a_thread_that_watches_is_woken_by_wake(fd_selector: FdSelector, pipe: Pipe) -> None:
    fd_selector.arm(pipe.reader, READ, lambda _, __: None)
    waiter = WireWaiter(ShutdownSignal(), fd_selector)
    waker = threading.Timer(0.02, waiter.wake)
    waker.start()
    assert waiter.wait(LONG)
    waker.join()
    waiter.wake()
    assert waiter.wait(LONG)


def test_a_sleeper_that_found_the_selector_taken_is_told_when_it_is_free(pipe: Pipe) -> None:
    told = threading.Event()
    fd_selector = FdSelector(told.set)
    fd_selector.arm(pipe.reader, READ, lambda _, __: None)
    told.clear()
    first, second = WireWaiter(ShutdownSignal(), fd_selector), WireWaiter(ShutdownSignal(), fd_selector)
    watching = threading.Thread(target=first.wait, args=(LONG,))
    watching.start()
    wait_for(fd_selector._turn.locked)
    sleeping = threading.Thread(target=second.wait, args=(LONG,))
    sleeping.start()
    wait_for(lambda: fd_selector.wanted)
    first.wake()
    assert told.wait(PATIENCE)
    second.wake()
    watching.join(PATIENCE)
    sleeping.join(PATIENCE)
    fd_selector.close()


def test_closing_sends_the_watching_thread_off_and_arms_nothing_more(
    fd_selector: FdSelector, pipe: Pipe
) -> None:
    fd_selector.arm(pipe.reader, READ, lambda _, __: None)
    waiter = WireWaiter(ShutdownSignal(), fd_selector)
    watching = threading.Thread(target=waiter.wait, args=(LONG,))
    watching.start()
    wait_for(fd_selector._turn.locked)
    fd_selector.close()
    watching.join(PATIENCE)
    assert not watching.is_alive()
    fd_selector.arm(pipe.reader, READ, lambda _, __: None)
    assert fd_selector.watched == 0
