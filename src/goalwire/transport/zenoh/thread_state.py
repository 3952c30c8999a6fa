"""Keeps one Python thread state per zenoh thread, instead of a new one for every callback.

Zenoh calls back on threads that Python did not start. Around each call a thread state is made and thrown
away, and the first frame in a fresh one allocates its stack: 9 µs a message. One PyGILState_Ensure that is
never matched keeps the state for the thread's life: 1 µs a message, 408,000 messages/s for 101,000
(zenoh-wire B.3).

This leans on CPython; GOALWIRE_PIN_THREADS=0 turns it off.
"""

from __future__ import annotations

import os
import sys
import threading
from collections.abc import Callable
from functools import partial


def _nothing() -> None:
    """Stand in for pinning where it is off."""


def _make_pin() -> Callable[[], object]:
    if os.environ.get('GOALWIRE_PIN_THREADS') == '0' or sys.implementation.name != 'cpython':
        return _nothing
    from ctypes import pythonapi

    ensure = pythonapi.PyGILState_Ensure

    class Pinned(threading.local):
        def __getattr__(self, name: str) -> object:  # asked on a thread that is not pinned yet
            self.done = True
            return ensure()

    return partial(getattr, Pinned(), 'done')


keep_thread_state: Callable[[], object] = _make_pin()
"""Call first in every zenoh callback: only the first call on a thread does anything, or runs Python code."""
