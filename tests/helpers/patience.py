"""How long a test waits for what must happen, and the waits that nothing more particular is there for.

Only a failure takes that long, on a busy machine too. A test's time limit is well above its waits.
"""

from __future__ import annotations

import threading
from collections.abc import Callable
from time import monotonic

PATIENCE = 60.0
"""Seconds for what programs that run do, and for the start and the end of one."""
COMMAND = 60.0
"""Seconds for a command line from its start to its end."""
NOTEBOOK = 60.0
"""Seconds for a kernel of Jupyter: its start, and a cell."""
BROWSER = 90.0
"""Seconds for a page in a browser, and for the console that serves it."""
BROWSER_MS = 1000 * BROWSER
"""The same as Playwright takes it."""

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
