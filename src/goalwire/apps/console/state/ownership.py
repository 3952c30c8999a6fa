"""The robot to which a name belongs, among robots with namespaces of their own.

A name is of the robot with the longest namespace that it lies in. A robot without a namespace has what no
other one has. What lies in no robot's namespace may only stop robots below it: it moves one of them only if
that is the only robot.
"""

from __future__ import annotations

from collections.abc import Collection


def owner(name: str, robots: Collection[str]) -> str | None:
    """Return the namespace of the robot that a name is of; None if it is of none."""
    found = [robot for robot in robots if name.startswith(f'{robot}/')]
    return max(found, key=len, default=None)


def may_stop(name: str, robot: str, robots: Collection[str]) -> bool:
    """Return whether a service or topic speaks for a robot: its own, or one of a namespace above it."""
    whose = owner(name, robots)
    return whose == robot or (whose is None and _is_above(name, robot))


def may_move(name: str, robot: str, robots: Collection[str]) -> bool:
    """Return whether a message to a name can move only this robot."""
    whose = owner(name, robots)
    return whose == robot or (whose is None and len(robots) == 1 and _is_above(name, robot))


def _is_above(name: str, robot: str) -> bool:
    return f'{robot}/'.startswith(name.rpartition('/')[0] + '/')
