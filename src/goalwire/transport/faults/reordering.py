"""Later ones overtake."""

from __future__ import annotations

from dataclasses import dataclass
from random import Random

from goalwire.transport.faults.fault import Fault, to_ns
from goalwire.transport.faults.packet import Packet


@dataclass(eq=False)
class Reordering(Fault):
    """Held back by `by` seconds, while what comes behind it passes."""

    by: float = 0.01

    def __post_init__(self) -> None:
        super().__post_init__()
        to_ns(self.by)

    def strike(self, packet: Packet, rng: Random, now: int) -> tuple[Packet, ...]:  # noqa: ARG002
        return (packet._replace(delay_ns=packet.delay_ns + to_ns(self.by), overtakes=True),)
