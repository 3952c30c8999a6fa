"""Finds the robot to which a name belongs, among robots with different namespaces.

A name belongs to the robot with the longest namespace that contains it. A robot without a namespace has all
other names. A name outside of all robots' namespaces may stop the robots below it, but may move a robot only
if it is the only one.
"""

from __future__ import annotations

from collections.abc import Collection


def owner(name: str, robots: Collection[str]) -> str | None:
    """Return the namespace of the robot to which a name belongs; None if it belongs to none."""
    found = [robot for robot in robots if name.startswith(f'{robot}/')]
    return max(found, key=len, default=None)


def may_stop(name: str, robot: str, robots: Collection[str]) -> bool:
    """Return True if a service or topic is for a robot: in its own namespace, or in one above it."""
    whose = owner(name, robots)
    return whose == robot or (whose is None and _is_above(name, robot))


def may_move(name: str, robot: str, robots: Collection[str]) -> bool:
    """Return whether a message to a name can move only this robot."""
    whose = owner(name, robots)
    return whose == robot or (whose is None and len(robots) == 1 and _is_above(name, robot))


def _is_above(name: str, robot: str) -> bool:
    return f'{robot}/'.startswith(name.rpartition('/')[0] + '/')
