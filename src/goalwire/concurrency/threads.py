"""Waiting for the end of a thread that Ctrl-C may have kept from its beginning."""

from __future__ import annotations

from threading import Thread


def join_begun(thread: Thread, timeout_s: float | None = None) -> bool:
    """Wait for a thread that was told to end; False at once if it is not known to have begun.

    Ctrl-C may come within `Thread.start`, and so leave a thread that never begins, or that has begun without
    the starter's knowledge. The second one ends by itself.
    """
    try:
        thread.join(timeout_s)
    except RuntimeError:  # Python's `join` knows only threads whose `start` has returned
        return False
    return True
