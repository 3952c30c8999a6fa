"""What is sent arrives twice: a message, or a request with one number, as a wire that repeats itself does."""

from __future__ import annotations

from dataclasses import dataclass
from random import Random

from goalwire.transport.faults.fault import Fault
from goalwire.transport.faults.packet import Kind, Packet


@dataclass(eq=False)
class Duplication(Fault):
    """Arrives twice in a row. A client takes one reply, so replies are left alone."""

    strikes_on = frozenset({Kind.MESSAGE, Kind.REQUEST})

    def strike(self, packet: Packet, rng: Random, now: int) -> tuple[Packet, ...]:  # noqa: ARG002
        return packet, packet
