"""How long a test waits for what must happen, and the waits that nothing more particular is there for."""

from __future__ import annotations

import threading
from collections.abc import Callable
from time import monotonic

PATIENCE = 20.0
"""Seconds that only a failure takes, on a busy machine too; well below the time limit of a test."""

_LOOK_AGAIN_S = 0.002


def soon(event: threading.Event) -> bool:
    """Wait for an event, as long as only a failure takes."""
    return event.wait(PATIENCE)


def wait_for(condition: Callable[[], object], what: str = 'it') -> None:
    """Wait until something holds of which nobody tells; it is looked at again and again.

    Where an event, a graph or a collector tells of it, wait for that.
    """
    deadline = monotonic() + PATIENCE
    pause = threading.Event()
    while not condition():
        assert monotonic() < deadline, f'waited in vain for {what}'
        pause.wait(_LOOK_AGAIN_S)
