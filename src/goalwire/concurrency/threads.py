"""Threads whose start a signal's handler may interrupt: beginning one, and waiting for its end."""

from __future__ import annotations

from _thread import allocate_lock, start_new_thread
from threading import Thread, get_ident, main_thread


def begin(thread: Thread) -> None:
    """Start a thread, also if the handler of a signal raises meanwhile: that exception comes out of here.

    Such an exception in the midst of `Thread.start` may keep the thread from running, or become a KeyError.
    So if this is the main thread, where handlers run, another thread calls `Thread.start`.
    """
    if get_ident() != main_thread().ident:
        thread.start()
        return
    errors: list[BaseException] = []
    has_started = allocate_lock()
    has_started.acquire()

    def start() -> None:
        try:
            thread.start()
        except BaseException as error:
            errors.append(error)
        finally:
            has_started.release()

    start_new_thread(start, ())  # a function of C: no handler runs in the midst of it
    has_started.acquire()
    if errors:
        raise errors[0]


def join_begun(thread: Thread, timeout_s: float | None = None) -> bool:
    """Wait for a thread that was told to end; return False at once if its start was interrupted.

    Ctrl-C may interrupt `Thread.start`. Then the thread never begins, or runs although `start` has not
    returned. In the second case it ends by itself.
    """
    try:
        thread.join(timeout_s)
    except RuntimeError:  # Python's `join` knows only threads whose `start` has returned
        return False
    return True
