"""The stand-ins, one by one: they take and refuse what the real ones do."""

from __future__ import annotations

import threading
import time
from collections.abc import Callable

import pytest
from helpers.patience import PATIENCE

from goalwire.testing import VirtualClock
from goalwire.testing.virtual import stand_ins


@pytest.mark.parametrize(
    'play',
    [
        lambda: stand_ins.Lock().acquire(blocking=False, timeout=1.0),
        lambda: _locked().acquire(timeout=-2.0),
        lambda: stand_ins.Lock().release(),
        lambda: time.sleep(-1.0),
        lambda: time.sleep('1'),  # type: ignore[arg-type]
        lambda: threading.Thread().join(),
        lambda: threading.current_thread().join(),
    ],
)
def test_mistakes_are_refused_as_the_real_ones_refuse_them(play: Callable[[], object]) -> None:
    with pytest.raises((ValueError, RuntimeError, TypeError)) as real:
        play()
    with VirtualClock(), pytest.raises(real.type) as virtual:
        play()
    assert str(virtual.value) == str(real.value)


def _locked() -> stand_ins.Lock:
    lock = stand_ins.Lock()
    lock.acquire()
    return lock


def test_a_lock_works_without_a_clock_too() -> None:
    lock = stand_ins.Lock()
    with lock:
        assert lock.locked()
        assert not lock.acquire(blocking=False)
        assert not lock.acquire(timeout=0.01)
        assert repr(lock).startswith('<locked goalwire stand-in')
    assert not lock.locked()
    lock.acquire()
    lock._at_fork_reinit()
    assert not lock.locked()


def test_a_lock_of_virtual_time_excludes_threads_of_real_time() -> None:
    taken: list[bool] = []
    asked, may_try = threading.Event(), threading.Event()

    def try_in_real_time() -> None:
        may_try.wait(PATIENCE)
        taken.append(lock.acquire(blocking=False))
        asked.set()
        taken.append(lock.acquire(timeout=PATIENCE))

    thread = threading.Thread(target=try_in_real_time)
    thread.start()
    with VirtualClock():
        lock = threading.Lock()
        with lock:
            may_try.set()
            while not asked.is_set():
                pass
    thread.join(PATIENCE)
    assert taken == [False, True]


def test_a_thread_that_cannot_be_started_is_nobody(
    clock: VirtualClock, monkeypatch: pytest.MonkeyPatch
) -> None:
    def refuse(thread: threading.Thread) -> None:
        raise RuntimeError("can't start new thread")

    monkeypatch.setattr(stand_ins, '_real_start', refuse)
    with pytest.raises(RuntimeError, match='start new thread'):
        threading.Thread(target=time.sleep, args=[1.0]).start()
    time.sleep(5.0)
    assert clock.elapsed == 5.0


def test_a_thread_with_a_run_of_its_own_class_runs_once_and_keeps_nothing(clock: VirtualClock) -> None:
    class Worker(threading.Thread):
        runs = 0

        def run(self) -> None:
            self.runs += 1
            time.sleep(1.0)

    worker = Worker()
    worker.start()
    worker.join()
    assert worker.runs == 1
    assert 'run' not in vars(worker)
