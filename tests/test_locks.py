"""A lock of goalwire.locks in a forked child: nobody waits there for a thread that was left behind."""

from __future__ import annotations

import os
import select
import signal
import sys
from collections.abc import Callable
from threading import Event, Thread
from types import FunctionType

import pytest

from goalwire.locks import ForkableLock

pytestmark = pytest.mark.skipif(sys.platform != 'linux', reason='uses pidfd')

LIMIT_S = 20


def succeeds_in_child(body: Callable[[], object]) -> bool:
    """Fork, run `body` in the child, and wait for it for a bounded time."""
    child = os.fork()
    if child == 0:
        try:
            body()
            os._exit(0)
        finally:
            os._exit(1)
    descriptor = os.pidfd_open(child)
    try:
        has_ended = bool(select.select([descriptor], [], [], LIMIT_S)[0])
    finally:
        os.close(descriptor)
    if not has_ended:
        os.kill(child, signal.SIGKILL)
    return os.waitstatus_to_exitcode(os.waitpid(child, 0)[1]) == 0 and has_ended


@pytest.mark.filterwarnings('ignore:.*fork.*:DeprecationWarning')
def test_a_child_finds_the_lock_of_a_thread_that_was_left_behind_free() -> None:
    lock, holds, may_end = ForkableLock(), Event(), Event()

    def hold() -> None:
        with lock:
            holds.set()
            may_end.wait()

    def take() -> None:
        with lock:
            pass

    holder = Thread(target=hold)
    holder.start()
    holds.wait()
    try:
        assert succeeds_in_child(take)
    finally:
        may_end.set()
        holder.join()


def test_the_thread_that_forks_keeps_what_it_holds() -> None:
    lock = ForkableLock()
    with lock:
        pass

    def leave_both_blocks() -> None:
        lock.__exit__(None, None, None)
        with pytest.raises(RuntimeError):
            lock.__exit__(None, None, None)

    with lock:
        assert succeeds_in_child(leave_both_blocks)


def test_a_signal_handler_that_raises_leaves_no_lock_held() -> None:
    """Handlers run in functions of Python alone: in one that takes the lock, the lock would stay held."""
    assert not isinstance(ForkableLock.__enter__, FunctionType)
    assert not isinstance(ForkableLock.__exit__, FunctionType)
