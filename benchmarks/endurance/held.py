"""The memory, threads and descriptors of processes, before and after (Linux)."""

from __future__ import annotations

import re
from pathlib import Path

from benchmarks.line import Figures
from benchmarks.soak.health import health


class Held:
    """The holdings of processes at one moment, by their names, and the growth since then."""

    def __init__(self, **pids: int) -> None:
        self._pids = pids
        self._before = {name: health(pid) for name, pid in pids.items()}

    def since(self) -> Figures:
        """Return memory at both moments in MiB, and how many threads and descriptors have been added."""
        figures: Figures = {}
        for name, pid in self._pids.items():
            before, after = self._before[name], health(pid)
            figures[f'{name} MiB before'] = before.rss_kib / 1024
            figures[f'{name} MiB'] = after.rss_kib / 1024
            figures[f'{name} threads'] = after.threads - before.threads
            figures[f'{name} files'] = after.descriptors - before.descriptors
        return figures


def peak_mib(pid: int) -> float:
    """Return the most memory that a process has ever had resident."""
    found = re.search(r'VmHWM:\s*(\d+) kB', Path(f'/proc/{pid}/status').read_text())
    return int(found.group(1)) / 1024 if found else 0.0
