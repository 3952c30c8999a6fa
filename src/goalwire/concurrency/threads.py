"""Threads whose start a signal's handler may interrupt: beginning one, and waiting for its end."""

from __future__ import annotations

from threading import Thread


def begin(thread: Thread) -> None:
    """Start a thread. If the handler of a signal raises meanwhile, raise that exception.

    `Thread.start` then takes the thread out of a table of threads that have not begun yet. If the thread has
    begun, it is not in that table any more, and a KeyError would hide the exception of the handler.
    """
    try:
        thread.start()
    except KeyError as error:
        if error.__context__ is None or error.args != (thread,):
            raise  # it is the handler's own
        raise error.__context__ from None


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
