"""What is sent does not arrive, and nobody says so."""

from __future__ import annotations

from dataclasses import dataclass
from random import Random

from goalwire.transport.faults.fault import Fault
from goalwire.transport.faults.packet import Packet


@dataclass(eq=False)
class Loss(Fault):
    """Lost, at the fault's rate."""

    def strike(self, packet: Packet, rng: Random, now: int) -> tuple[Packet, ...]:  # noqa: ARG002
        return ()
