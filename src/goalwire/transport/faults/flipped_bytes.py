"""What arrives is not what was sent."""

from __future__ import annotations

from dataclasses import dataclass
from random import Random

from goalwire.transport.faults.crossing import Crossing
from goalwire.transport.faults.fault import Fault

_HEADER = 4
"""Bytes of encapsulation before every message; a wire may read them itself, so they are left alone."""


@dataclass(eq=False)
class FlippedBytes(Fault):
    """So many bytes of it are others."""

    number: int = 1

    def strike(self, crossing: Crossing, luck: Random, now: int) -> tuple[Crossing, ...]:  # noqa: ARG002
        content = bytearray(crossing.payload)
        for _ in range(self.number if len(content) > _HEADER else 0):
            content[luck.randrange(_HEADER, len(content))] ^= luck.randrange(1, 256)
        return (crossing._replace(payload=bytes(content)),)
