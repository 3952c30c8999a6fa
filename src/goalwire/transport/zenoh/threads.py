"""Zenoh's threads: how they end with the process, after a fork, and how calls from them are made cheap.

A zenoh thread that calls into an interpreter on its way out aborts the process. So every open session is
closed before that (endpoint.close_at_exit), and its callbacks are waited for. A forked child has no zenoh
threads, so closing, or even dropping, what its parent opened could wait for ever: the child leaks it on
purpose.

Zenoh calls back on threads that Python did not start. Python creates a thread state for each call and deletes
it afterwards, and the first frame in a new state allocates its stack: 9 µs a message. A call of
PyGILState_Ensure without a matching release keeps the state for the thread's life. That takes 1 µs a message,
and 408,000 messages/s pass instead of 101,000. This leans on CPython; GOALWIRE_PIN_THREADS=0 turns it off.
"""

from __future__ import annotations

import os
import sys
import threading
import time
from collections.abc import Callable
from functools import partial

import zenoh

from goalwire.concurrency.exits import Stage, at_exit
from goalwire.concurrency.forks import ForkGuard
from goalwire.errors import ForkedError

RUNTIME = (
    '(rx: (worker_threads: 1), app: (handover: rx), net: (worker_threads: 1), acc: (handover: net), '
    'tx: (worker_threads: 1))'
)
"""Zenoh's thread pools, merged to three threads: receiving, network upkeep, sending.

Fewer threads would be faster, but block for ever. Zenoh answers a late subscriber on the receiving thread and
waits for room: if that thread also sends, 128 KiB of history stop the session. And to undeclare an advanced
publisher waits, with the GIL held, for a task of the upkeep thread: if that thread also receives, it may
itself wait for the GIL to run a callback.
"""


NOISY = ('zenoh::api::session', 'zenoh::net::routing::hat::peer::interests')
"""Parts of zenoh that log errors without a cause: "Received Data for unknown key_expr" if a session comes or
goes under traffic, and "Unknown interest" if an answer arrives for a question that was withdrawn."""

LOG_FILTER = ','.join(['error', *(f'{part}=off' for part in NOISY)])
"""The log filter of zenoh if RUST_LOG is not set: errors, except those of NOISY."""


CALLERS_S = 1.0
"""How long the end of a program waits until daemon threads have returned from calls of zenoh."""

_HERE = os.path.dirname(__file__)  # noqa: PTH120 - compared with file names, as text


_started: list[ForkGuard] = []
"""Empty until a session is opened; then has the guard that detects forked children of this process."""


RUNTIME_VARIABLE = 'ZENOH_RUNTIME'
"""The environment variable that sets the thread pools. Zenoh reads it when its threads start, with the first
session of a process."""

_has_threads = False
"""True once a session has been opened: then zenoh does not read the variable again."""


def open_session(config: zenoh.Config) -> zenoh.Session:
    """Open a session with the threads of `RUNTIME`, unless ZENOH_RUNTIME asks for others.

    Raises ZError, and ForkedError in a child whose parent has opened a session.
    """
    global _has_threads  # noqa: PLW0603 - zenoh starts its threads once a process
    if not _started:
        zenoh.init_log_from_env_or(LOG_FILTER)
        _started.append(ForkGuard())
        at_exit(Stage.LIBRARIES, _let_callers_out)
    elif _started[0].is_forked:
        raise ForkedError(
            'this process was forked from one with a Zenoh session open, and Zenoh cannot be started again '
            "in such a child; start it with subprocess or multiprocessing's spawn method, or fork first"
        )
    sets_variable = not _has_threads and RUNTIME_VARIABLE not in os.environ
    if sets_variable:
        os.environ[RUNTIME_VARIABLE] = RUNTIME
    try:
        session = zenoh.open(config)
    finally:
        if sets_variable:  # child programs should not inherit the variable
            os.environ.pop(RUNTIME_VARIABLE, None)
    _has_threads = True
    return session


def _let_callers_out() -> None:
    """Wait until daemon threads have returned from calls of zenoh, which fail now.

    Python unwinds a thread that returns into an ending interpreter; inside Rust code this aborts the process.
    This polls, since a counter of such threads would slow every message down.
    """
    deadline = time.monotonic() + CALLERS_S
    while _has_callers() and time.monotonic() < deadline:
        time.sleep(0.001)


def _has_callers() -> bool:
    ours = threading.get_ident()
    frames = sys._current_frames().items()  # documented by Python, for debugging
    return any(frame.f_code.co_filename.startswith(_HERE) for thread, frame in frames if thread != ours)


def _nothing() -> None:
    """Do nothing; used if thread states are not kept."""


def _make_pin() -> Callable[[], object]:
    if os.environ.get('GOALWIRE_PIN_THREADS') == '0' or sys.implementation.name != 'cpython':
        return _nothing
    from ctypes import pythonapi

    ensure = pythonapi.PyGILState_Ensure

    class Pinned(threading.local):
        def __getattr__(self, name: str) -> object:  # called on a thread whose state is not kept yet
            self.done = True
            return ensure()

    return partial(getattr, Pinned(), 'done')


keep_thread_state: Callable[[], object] = _make_pin()
"""Keeps the thread's state. Every zenoh callback calls this first; only the first call on a thread acts."""
