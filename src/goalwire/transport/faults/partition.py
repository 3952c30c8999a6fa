"""Two nodes, or two groups of nodes, that the wire no longer connects."""

from __future__ import annotations

from dataclasses import dataclass, field
from fnmatch import fnmatchcase
from random import Random

from goalwire.transport.faults.fault import Fault, qualified, to_ns
from goalwire.transport.faults.packet import Packet

LEASE_S = 10.0
"""How long a silent peer stays in the graph: Zenoh's link lease and Cyclone's participant lease."""


@dataclass(eq=False)
class Partition(Fault):
    """Nothing gets from `here` to `there`, nor back unless it is `one_way`; what is sent meanwhile is lost.

    After `lease` seconds each side also loses the other from its graph, and the calls that wait for it end.
    """

    here: str = field(kw_only=False)
    there: str = field(kw_only=False, default='*')
    one_way: bool = False
    lease: float = LEASE_S
    noticed_at: int = field(default=0, init=False)
    """When the lease ends, in ns of the clock."""

    def __post_init__(self) -> None:
        super().__post_init__()
        to_ns(self.lease)
        self.here, self.there = qualified(self.here), qualified(self.there)

    def begin(self, now: int) -> None:
        """Begin, and with it the lease."""
        self.noticed_at = now + to_ns(self.lease)

    def cuts(self, source: str, target: str) -> bool:
        """Whether nothing gets from `source` to `target`."""
        return self._forth(source, target) or (not self.one_way and self._forth(target, source))

    def _forth(self, source: str, target: str) -> bool:
        return source != target and fnmatchcase(source, self.here) and fnmatchcase(target, self.there)

    def meets(self, packet: Packet) -> bool:
        return super().meets(packet) and self.cuts(packet.source, packet.target)

    def strike(self, packet: Packet, rng: Random, now: int) -> tuple[Packet, ...]:  # noqa: ARG002
        return ()
