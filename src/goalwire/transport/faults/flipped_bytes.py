"""What arrives is not what was sent."""

from __future__ import annotations

from dataclasses import dataclass
from random import Random

from goalwire.transport.faults.fault import Fault
from goalwire.transport.faults.packet import Packet

_HEADER = 4
"""Bytes of encapsulation before every message; a wire may read them itself, so they are left alone."""


@dataclass(eq=False)
class FlippedBytes(Fault):
    """So many bytes of it are others."""

    number: int = 1

    def strike(self, packet: Packet, rng: Random, now: int) -> tuple[Packet, ...]:  # noqa: ARG002
        content = bytearray(packet.payload)
        for _ in range(self.number if len(content) > _HEADER else 0):
            content[rng.randrange(_HEADER, len(content))] ^= rng.randrange(1, 256)
        return (packet._replace(payload=bytes(content)),)
