"""A line of the benchmark table: its work, the figures it gives, and the goals they are held to."""

from __future__ import annotations

from collections.abc import Mapping
from enum import Enum
from types import MappingProxyType
from typing import NamedTuple, TypeAlias

Figures: TypeAlias = dict[str, float]
"""The results of one run of a program, by name: `p50`, `p99`, `cpu` … in µs; see FIGURES."""

NONE: Mapping[str, float] = MappingProxyType({})

FIGURES: Mapping[str, tuple[str, str]] = MappingProxyType({
    'p50': ('µs', 'half of the operations took no longer'),
    'p99': ('µs', 'all but one in a hundred took no longer'),
    'cpu': ('µs', 'CPU of both processes, an operation'),
    'cpu_here': ('µs', 'CPU of the process that measures, an operation'),
    'cpu_there': ('µs', 'CPU of its partner, an operation'),
    'rate': ('/s', 'operations a second'),
    'lost': ('', 'operations that never ended'),
    'arrived': ('', 'share of what was sent'),
    'growth': ('', 'last hundred operations to the first hundred, medians'),
    'wall': ('ms', 'from the start of the process'),
    'inside': ('ms', "from the program's first line"),
    'memory': ('MB', 'resident'),
    'first': ('ms', 'the first goal'),
    'tenth': ('ms', 'the tenth goal'),
    'first_to_tenth': ('', 'the first goal to the tenth'),
    'found': ('s', 'until everybody has found everybody'),
    'idle': ('%', 'of one core, for each process'),
})  # fmt: skip
"""Every figure's unit and meaning."""


class Of(Enum):
    """The base of a goal's limit: the limit is a multiple of it."""

    REFERENCE = "the real rclpy's figure in the reference configuration"
    RAW = "the raw wire's figure, measured beside"
    TCP = 'the figure of plain Python on TCP, measured beside'
    ECLIPSE = "goalwire's figure on eclipse-zenoh's session, measured beside"
    ONE = 'nothing: the limit is the figure itself'


class Goal(NamedTuple):
    """A limit for one figure on either wire, None if there is none; `at_least` where more is better.

    `no_look` is the limit on Zenoh where nobody looks at the wire before a sleep.
    """

    figure: str
    of: Of
    zenoh: float | None
    dds: float | None
    at_least: bool = False
    no_look: float | None = None


class Line(NamedTuple):
    """One row of the table.

    `operations` are done in a round. `reference` holds the real rclpy's figures on a quiet 2-core machine
    (Jazzy, Cyclone DDS); `floor` names the work that the programs of the raw wires do beside it; `peer` is
    false where the real rclpy has nothing like it. `looks` is false where a look at the wire before a sleep
    changes nothing, `spins` where another executor changes nothing. The two processes run where the system
    puts them, or each `pinned` to one processor.
    """

    name: str
    module: str
    operations: int
    figures: tuple[str, ...]
    goals: tuple[Goal, ...]
    reference: Mapping[str, float] = NONE
    floor: str = ''
    peer: bool = True
    rounds: int = 3
    looks: bool = True
    spins: bool = True
    pinned: bool = False
