"""Waits for the end of a thread whose start Ctrl-C may have interrupted."""

from __future__ import annotations

from threading import Thread


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
