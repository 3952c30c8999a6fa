"""A reader, or a line, that takes so many things a second and no more."""

from __future__ import annotations

from collections import defaultdict, deque
from dataclasses import dataclass, field
from random import Random

from goalwire.transport.faults.crossing import Crossing, Kind, Path
from goalwire.transport.faults.fault import Fault, to_ns


@dataclass(eq=False)
class SlowReader(Fault):
    """One thing each `period` seconds on every path; of a topic's messages `room` may wait, more are lost."""

    period: float = field(kw_only=False)
    room: int = 100
    lost: int = field(default=0, init=False)
    """Messages for which there was no room."""
    _due: dict[Path, deque[int]] = field(default_factory=lambda: defaultdict(deque), init=False, repr=False)
    """When each of those that wait on a path will be read."""

    def __post_init__(self) -> None:
        super().__post_init__()
        to_ns(self.period)

    def strike(self, crossing: Crossing, luck: Random, now: int) -> tuple[Crossing, ...]:  # noqa: ARG002
        waiting = self._due[crossing.path]
        while waiting and waiting[0] + to_ns(self.period) <= now:
            waiting.popleft()
        if crossing.kind is Kind.MESSAGE and len(waiting) > self.room:
            self.lost += 1
            return ()
        arrival = now + crossing.delay_ns
        due = max(arrival, waiting[-1] + to_ns(self.period)) if waiting else arrival
        waiting.append(due)
        return (crossing._replace(delay_ns=due - now),)
