"""The health of a process: its memory, threads and descriptors (Linux)."""

from __future__ import annotations

import os
from pathlib import Path
from typing import NamedTuple

PAGE_KIB = os.sysconf('SC_PAGE_SIZE') // 1024


class Health(NamedTuple):
    """Of one process at one moment."""

    rss_kib: int
    threads: int
    descriptors: int


def health(pid: int) -> Health:
    """Raises FileNotFoundError for a process that has ended."""
    process = Path('/proc') / str(pid)
    return Health(
        int((process / 'statm').read_text().split()[1]) * PAGE_KIB,
        sum(1 for _ in (process / 'task').iterdir()),
        sum(1 for _ in (process / 'fd').iterdir()),
    )


def worse(name: str, samples: list[Health]) -> list[str]:
    """Say what has grown between the first quarter and the end.

    Memory may grow by a tenth and 8 MiB, threads by 4, descriptors by 12: peers come and go, and who takes
    the rendezvous of another that was killed gets a connection from every process.
    """
    if len(samples) < 8:
        return []
    quarter, early, late = len(samples) // 4, samples[len(samples) // 8 :], samples
    before = Health(*(max(values) for values in zip(*early[:quarter], strict=True)))
    after = Health(*(min(values) for values in zip(*late[-quarter:], strict=True)))
    limits = Health(before.rss_kib * 11 // 10 + 8192, before.threads + 4, before.descriptors + 12)
    return [
        f'{name}: {what} went from {was} to {now}'
        for what, was, now, limit in zip(Health._fields, before, after, limits, strict=True)
        if now > limit
    ]
