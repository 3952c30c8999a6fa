"""A long way: everything arrives later, in order."""

from __future__ import annotations

from dataclasses import dataclass, field
from random import Random

from goalwire.transport.faults.fault import Fault, to_ns
from goalwire.transport.faults.packet import Packet


@dataclass(eq=False)
class Delay(Fault):
    """Late by `seconds`, and by up to `jitter` seconds more."""

    seconds: float = field(kw_only=False)
    jitter: float = 0.0

    def __post_init__(self) -> None:
        super().__post_init__()
        to_ns(self.seconds)
        to_ns(self.jitter)

    def strike(self, packet: Packet, rng: Random, now: int) -> tuple[Packet, ...]:  # noqa: ARG002
        extra = rng.uniform(0.0, self.jitter) if self.jitter else 0.0
        return (packet._replace(delay_ns=packet.delay_ns + to_ns(self.seconds + extra)),)
