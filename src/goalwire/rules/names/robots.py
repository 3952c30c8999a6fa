"""The robots of a fleet: each robot has all its nodes and names below its own namespace.

The first part of a namespace is the robot's name: a node in /alpha/arm belongs to the robot 'alpha'. A node
in the namespace / belongs to no robot.
"""

from __future__ import annotations

from fnmatch import fnmatchcase
from typing import TYPE_CHECKING

from goalwire.patterns import Pattern
from goalwire.records import record
from goalwire.rules.names.expansion import join

if TYPE_CHECKING:
    from collections.abc import Iterable

_PATTERN = Pattern(r'[A-Za-z_*][A-Za-z0-9_*]*')


def robot_of(namespace: str) -> str:
    """Return the robot that a node's namespace belongs to; '' for the namespace /."""
    return namespace.lstrip('/').partition('/')[0]


def name_below(robot: str, name: str) -> str:
    """Return the full name that a relative name has on a robot; an absolute name is returned unchanged."""
    return name if name.startswith('/') else join(f'/{robot}', name)


def check_pattern(text: str, *, is_name: bool = False) -> str:
    """Return a robot's name, or a pattern of names ('*' stands for any text), without outer slashes.

    Raises ValueError for a text that is neither; if `is_name` is true, also for a pattern.
    """
    pattern = text.strip('/')
    if _PATTERN.fullmatch(pattern) is None or (is_name and '*' in pattern):
        kind = 'name of a robot' if is_name else 'pattern of names of robots'
        more = '' if is_name else "; '*' stands for any text"
        raise ValueError(f"'{text}' is not a {kind}: it has letters, digits and underscores{more}")
    while '**' in pattern:
        pattern = pattern.replace('**', '*')
    return pattern


@record
class RobotView:
    """A choice of robots, for example those that a page of the console shows."""

    patterns: tuple[str, ...]
    """Names, or patterns of names, of robots."""
    nodes_only: bool = False
    """True to see nodes without their endpoints."""

    def covers(self, namespace: str) -> bool:
        """Return whether the view contains the nodes in this namespace."""
        return self.has(robot_of(namespace))

    def has(self, robot: str) -> bool:
        """Return whether the view contains a robot."""
        return bool(robot) and any(fnmatchcase(robot, pattern) for pattern in self.patterns)


def view_of(patterns: str | Iterable[str], *, nodes_only: bool = False) -> RobotView:
    """Return the view of one or several patterns.

    Raises ValueError for a bad pattern, or without patterns.
    """
    given = (patterns,) if isinstance(patterns, str) else tuple(patterns)
    if not given:
        raise ValueError("no robots are named: '*' stands for all")
    return RobotView(tuple(check_pattern(each) for each in given), nodes_only)
