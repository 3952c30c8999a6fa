"""A reader, or a line, that takes so much a second and no more."""

from __future__ import annotations

import math
from collections import defaultdict, deque
from dataclasses import dataclass, field
from random import Random

from goalwire.transport.faults.fault import Fault, to_ns
from goalwire.transport.faults.packet import Kind, Packet, Path


@dataclass(eq=False)
class SlowReader(Fault):
    """Busy for `period` seconds with each thing, and so long for each byte that it does `bytes_per_s`.

    Each path has a reader of its own. Of a topic's messages `room` may wait, more are lost.
    """

    period: float = field(default=0.0, kw_only=False)
    bytes_per_s: float = math.inf
    room: int = 100
    lost: int = field(default=0, init=False)
    """Messages for which there was no room."""
    _busy: dict[Path, deque[int]] = field(default_factory=lambda: defaultdict(deque), init=False, repr=False)
    """When it will be done with each of those that are on a path."""

    def __post_init__(self) -> None:
        super().__post_init__()
        to_ns(self.period)
        if not self.bytes_per_s > 0:
            raise ValueError(f'a reader takes some bytes a second, got {self.bytes_per_s}')

    def strike(self, packet: Packet, rng: Random, now: int) -> tuple[Packet, ...]:  # noqa: ARG002
        busy = self._busy[packet.path]
        while busy and busy[0] <= now:
            busy.popleft()
        if packet.kind is Kind.MESSAGE and len(busy) > self.room:
            self.lost += 1
            return ()
        arrival = now + packet.delay_ns
        due = max(arrival, busy[-1]) if busy else arrival
        busy.append(due + to_ns(self.period + len(packet.payload) / self.bytes_per_s))
        return (packet._replace(delay_ns=due - now),)
