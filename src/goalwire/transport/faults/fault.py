"""What every fault has: where it strikes, how often, and how often it has."""

from __future__ import annotations

from abc import ABC, abstractmethod
from dataclasses import dataclass, field
from fnmatch import fnmatchcase
from random import Random
from typing import ClassVar

from goalwire.transport.faults.packet import Kind, Packet

EVERYTHING: frozenset[Kind] = frozenset(Kind)


@dataclass(eq=False, kw_only=True)
class Fault(ABC):
    """One fault. Nodes and names are matched as a shell matches files; a node without a slash is of '/'."""

    rate: float = 1.0
    """The share of what passes that is struck, at random."""
    times: int | None = None
    """How often it strikes before it is over; None: without end."""
    source: str = '*'
    target: str = '*'
    name: str = '*'
    kind: Kind | None = None
    struck: int = field(default=0, init=False)
    """How often it has struck."""

    strikes_on: ClassVar[frozenset[Kind]] = EVERYTHING

    def __post_init__(self) -> None:
        if not 0.0 <= self.rate <= 1.0:
            raise ValueError(f'the rate of a fault is a share from 0 to 1, got {self.rate}')
        self.source, self.target = qualified(self.source), qualified(self.target)

    def meets(self, packet: Packet) -> bool:
        """Whether it is about this one at all."""
        return (
            packet.kind in self.strikes_on
            and self.kind in {None, packet.kind}
            and fnmatchcase(packet.name, self.name)
            and fnmatchcase(packet.source, self.source)
            and fnmatchcase(packet.target, self.target)
        )

    def apply(self, packet: Packet, rng: Random, now: int) -> tuple[Packet, ...]:
        """Return what becomes of a crossing at `now` (ns): nothing, itself, something else, several."""
        if (self.times is not None and self.struck >= self.times) or not self.meets(packet):
            return (packet,)
        if self.rate < 1.0 and rng.random() >= self.rate:
            return (packet,)
        self.struck += 1
        return self.strike(packet, rng, now)

    @abstractmethod
    def strike(self, packet: Packet, rng: Random, now: int) -> tuple[Packet, ...]:
        """Do it."""


def qualified(node: str) -> str:
    """Return a node's name, or a pattern of names, with its namespace."""
    return node if node.startswith(('/', '*')) else f'/{node}'


def to_ns(seconds: float) -> int:
    """Return a duration in ns; raises ValueError for a negative one."""
    if not seconds >= 0:
        raise ValueError(f'a duration is not negative, got {seconds}')
    return int(seconds * 1e9)
