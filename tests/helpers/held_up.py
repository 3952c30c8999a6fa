"""How long a busy machine let a program wait for a core, so that a test can leave that time out.

A test that insists on "within a second" is about what goalwire waits for, not about the machine's other work.
"""

from __future__ import annotations

import os
from contextlib import suppress
from pathlib import Path


class HeldUp:
    """The time that the threads of this process, and of other processes, wait for a core from now on."""

    def __init__(self, *others: int) -> None:
        """`others` are the process ids of the other processes."""
        self._processes = [os.getpid(), *others]
        self._before = self._waited()

    @property
    def seconds(self) -> float:
        """The waits of all threads since the beginning together, in s; 0 where the system does not tell."""
        after = self._waited()
        return sum(waited - self._before.get(thread, 0) for thread, waited in after.items()) / 1e9

    def _waited(self) -> dict[Path, int]:
        """Return how long each thread has waited for a core, in ns (proc(5), schedstat)."""
        found = {}
        for process in self._processes:
            for thread in Path(f'/proc/{process}/task').glob('*/schedstat'):
                with suppress(OSError):  # it has ended
                    found[thread] = int(thread.read_text().split()[1])
        return found
