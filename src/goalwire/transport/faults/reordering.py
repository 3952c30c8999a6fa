"""Later ones overtake."""

from __future__ import annotations

from dataclasses import dataclass
from random import Random

from goalwire.transport.faults.crossing import Crossing
from goalwire.transport.faults.fault import Fault, to_ns


@dataclass(eq=False)
class Reordering(Fault):
    """Held back by `by` seconds, while what comes behind it passes."""

    by: float = 0.01

    def __post_init__(self) -> None:
        super().__post_init__()
        to_ns(self.by)

    def strike(self, crossing: Crossing, luck: Random, now: int) -> tuple[Crossing, ...]:  # noqa: ARG002
        return (crossing._replace(delay_ns=crossing.delay_ns + to_ns(self.by), overtakes=True),)
