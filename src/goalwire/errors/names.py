"""Errors of names: those that ROS 2 forbids, and those of robots that nobody has."""

from __future__ import annotations

import re
from collections.abc import Iterable

from goalwire.errors.base import GoalwireError, LocalError
from goalwire.errors.wording import LONGEST_SHOWN, did_you_mean, peer_text, point_at, with_advice
from goalwire.files import show


class TopicExpansionError(LocalError, ValueError):
    """No fully-qualified name can be made of a topic name, node name or namespace."""

    def __init__(self, kind: str, name: str, reason: str) -> None:
        what = 'node namespace' if kind == 'namespace' else kind
        super().__init__(f"{what} '{show(name, LONGEST_SHOWN)}' is invalid: {show(reason, LONGEST_SHOWN)}")
        self.reason = reason


class NameValidationException(LocalError):
    """ROS 2 forbids a name, for the given `reason`; the text points at the wrong character."""

    def __init__(self, name_type: str, name: str, error_msg: str, invalid_index: int) -> None:
        self.reason = error_msg
        super().__init__(point_at(name_type, name, error_msg, invalid_index))
        if (better := _find_allowed_name(name_type, name)) != name:
            self.add_note(f"use letters, digits and '_', and begin with a letter: write {better!r}")


def _find_allowed_name(name_type: str, name: str) -> str:
    """Return a similar name that is allowed; `name` itself if more is wrong with it than
    single characters.
    """
    if not name or len(name) > LONGEST_SHOWN or re.search(r'[~{}]|//|/$', name):
        return name
    others = r'[^A-Za-z0-9_]+' if name_type == 'node name' else r'[^A-Za-z0-9_/]+'
    return re.sub(r'(^|/)(?=[0-9])', r'\1my_', re.sub(others, '_', name))


class InvalidNodeNameException(NameValidationException):
    """ROS 2 forbids this node name."""

    def __init__(self, name: str, error_msg: str, invalid_index: int) -> None:
        super().__init__('node name', name, error_msg, invalid_index)


class InvalidNamespaceException(NameValidationException):
    """ROS 2 forbids this namespace."""

    def __init__(self, name: str, error_msg: str, invalid_index: int) -> None:
        super().__init__('namespace', name, error_msg, invalid_index)


class InvalidTopicNameException(NameValidationException):
    """ROS 2 forbids this topic name."""

    def __init__(self, name: str, error_msg: str, invalid_index: int) -> None:
        super().__init__('topic name', name, error_msg, invalid_index)


class InvalidServiceNameException(NameValidationException):
    """ROS 2 forbids this service name."""

    def __init__(self, name: str, error_msg: str, invalid_index: int) -> None:
        super().__init__('service name', name, error_msg, invalid_index)


class NoRobotError(GoalwireError, LookupError):
    """No robot of a fleet has that name, or a name that matches that pattern."""

    def __init__(self, robot: str, known: Iterable[str]) -> None:
        """`known` are the names of the existing robots; the text suggests the names that were
        probably meant.
        """
        from difflib import get_close_matches

        self.robot = robot
        self.known = tuple(known)
        near = did_you_mean(get_close_matches(robot, self.known, 3, 0.6))
        shown = ', '.join(map(peer_text, self.known[:10])) + (', …' if self.known[10:] else '')
        there = f'there are: {shown}' if self.known else 'there are no robots'
        super().__init__(with_advice(f"there is no robot '{robot}'", near or there))
