"""What every fault has: where it strikes, how often, and how often it has."""

from __future__ import annotations

from abc import ABC, abstractmethod
from dataclasses import dataclass, field
from fnmatch import fnmatchcase
from random import Random
from typing import ClassVar

from goalwire.transport.faults.crossing import Crossing, Kind

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

    def meets(self, crossing: Crossing) -> bool:
        """Whether it is about this one at all."""
        return (
            crossing.kind in self.strikes_on
            and self.kind in {None, crossing.kind}
            and fnmatchcase(crossing.name, self.name)
            and fnmatchcase(crossing.source, self.source)
            and fnmatchcase(crossing.target, self.target)
        )

    def apply(self, crossing: Crossing, luck: Random, now: int) -> tuple[Crossing, ...]:
        """Return what becomes of a crossing at `now` (ns): nothing, itself, something else, several."""
        if (self.times is not None and self.struck >= self.times) or not self.meets(crossing):
            return (crossing,)
        if self.rate < 1.0 and luck.random() >= self.rate:
            return (crossing,)
        self.struck += 1
        return self.strike(crossing, luck, now)

    @abstractmethod
    def strike(self, crossing: Crossing, luck: Random, now: int) -> tuple[Crossing, ...]:
        """Do it."""


def qualified(node: str) -> str:
    """Return a node's name, or a pattern of names, with its namespace."""
    return node if node.startswith(('/', '*')) else f'/{node}'


def to_ns(seconds: float) -> int:
    """Return a duration in ns; raises ValueError for a negative one."""
    if not seconds >= 0:
        raise ValueError(f'a duration is not negative, got {seconds}')
    return int(seconds * 1e9)
