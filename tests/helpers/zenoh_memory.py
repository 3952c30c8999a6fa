"""Zenoh sessions that share memory: their settings, and what they hold of it."""

from __future__ import annotations

from collections.abc import Callable
from contextlib import suppress
from pathlib import Path

from helpers.zenoh_sides import Ours

from goalwire.zenoh.io.settings import MemorySettings
from goalwire.zenoh.io.shared_memory.segments import FOLDER, SUFFIX

WITH_OWN = MemorySettings(with_own=True, least=1024, pool_size=16 << 20)
WITH_ALL = MemorySettings(with_own=True, with_all=True, least=1024, pool_size=16 << 20)

OpenPair = Callable[..., tuple[Ours, Ours]]


def segments_of(process: int) -> set[Path]:
    """The segments that a process has open."""
    found = set()
    for each in Path(f'/proc/{process}/fd').iterdir():
        with suppress(OSError):  # closed meanwhile
            target = each.readlink()
            if target.parent == Path(FOLDER) and target.suffix == SUFFIX:
                found.add(target)
    return found


def lent(side: Ours) -> int:
    """How many chunks the readers of a session hold."""
    pool = side.session._memory.pool
    assert pool is not None
    pool._section.run(pool._collect)
    return sum(len(reader.chunks) for reader in pool._readers)


def shares(side: Ours) -> list[bool]:
    """For each link of a session, whether it has shared memory."""
    return [link.outgoing.memory is not None for link in side.protocol.links]
