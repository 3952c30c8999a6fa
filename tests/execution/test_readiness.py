from __future__ import annotations

import os
import selectors
import threading
from collections.abc import Iterator

import pytest
from helpers.execution import PATIENCE

from goalwire.execution.lifeline import Lifeline
from goalwire.execution.readiness import Parker, Readiness

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
def readiness() -> Iterator[Readiness]:
    readiness = Readiness(lambda: None)
    yield readiness
    readiness.close()


def test_a_ready_descriptor_is_reported_once_until_it_is_armed_again(
    readiness: Readiness, pipe: Pipe
) -> None:
    reports: list[tuple[int, int]] = []
    readiness.arm(pipe.reader, READ, lambda fd, events: reports.append((fd, events)))
    readiness.poll()
    assert reports == []
    pipe.write()
    readiness.poll()
    readiness.poll()
    assert reports == [(pipe.reader, READ)]
    assert readiness.watched == 0
    readiness.arm(pipe.reader, READ, lambda fd, events: reports.append((fd, events)))
    readiness.poll()
    assert len(reports) == 2


def test_a_disarmed_descriptor_is_not_reported(readiness: Readiness, pipe: Pipe) -> None:
    reports: list[int] = []
    readiness.arm(pipe.reader, READ, lambda fd, _: reports.append(fd))
    readiness.disarm(pipe.reader)
    readiness.disarm(pipe.reader)
    pipe.write()
    readiness.poll()
    assert reports == []


def test_a_parked_thread_wakes_for_a_descriptor(readiness: Readiness, pipe: Pipe) -> None:
    reports: list[int] = []
    readiness.arm(pipe.reader, READ, lambda fd, _: reports.append(fd))
    writer = threading.Timer(0.02, pipe.write)
    writer.start()
    Parker(readiness, Lifeline()).wait(LONG)
    assert reports == [pipe.reader]
    writer.join()


def test_a_thread_that_watches_is_woken_by_wake(readiness: Readiness, pipe: Pipe) -> None:
    readiness.arm(pipe.reader, READ, lambda _, __: None)
    parker = Parker(readiness, Lifeline())
    waker = threading.Timer(0.02, parker.wake)
    waker.start()
    assert parker.wait(LONG)
    waker.join()
    parker.wake()
    assert parker.wait(LONG)


def test_a_sleeper_that_found_the_selector_taken_is_told_when_it_is_free(pipe: Pipe) -> None:
    told = threading.Event()
    readiness = Readiness(told.set)
    readiness.arm(pipe.reader, READ, lambda _, __: None)
    told.clear()
    first, second = Parker(readiness, Lifeline()), Parker(readiness, Lifeline())
    watching = threading.Thread(target=first.wait, args=(LONG,))
    watching.start()
    while not readiness.attended:
        told.wait(0.001)
    sleeping = threading.Thread(target=second.wait, args=(LONG,))
    sleeping.start()
    while not readiness.wanted:
        told.wait(0.001)
    first.wake()
    assert told.wait(PATIENCE)
    second.wake()
    watching.join(PATIENCE)
    sleeping.join(PATIENCE)
    readiness.close()


def test_closing_sends_the_watching_thread_off_and_arms_nothing_more(
    readiness: Readiness, pipe: Pipe
) -> None:
    readiness.arm(pipe.reader, READ, lambda _, __: None)
    parker = Parker(readiness, Lifeline())
    watching = threading.Thread(target=parker.wait, args=(LONG,))
    watching.start()
    while not readiness.attended:
        watching.join(0.001)
    readiness.close()
    watching.join(PATIENCE)
    assert not watching.is_alive()
    readiness.arm(pipe.reader, READ, lambda _, __: None)
    assert readiness.watched == 0
