"""What is sent does not arrive, and nobody says so."""

from __future__ import annotations

from dataclasses import dataclass
from random import Random

from goalwire.transport.faults.crossing import Crossing
from goalwire.transport.faults.fault import Fault


@dataclass(eq=False)
class Loss(Fault):
    """Lost, at the fault's rate."""

    def strike(self, crossing: Crossing, luck: Random, now: int) -> tuple[Crossing, ...]:  # noqa: ARG002
        return ()
