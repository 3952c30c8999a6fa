"""The outcome of setting parameters: accepted, or refused with a reason (SetParametersResult)."""

from __future__ import annotations

from typing import NamedTuple


class Outcome(NamedTuple):
    """Whether parameters may be set, and why not, for people."""

    successful: bool
    reason: str = ''


class WrongType(Outcome):
    """A refusal of a value's type: a declaration raises another of rclpy's exceptions then."""


ACCEPTED = Outcome(successful=True)


def refused(reason: str, kind: type[Outcome] = Outcome) -> Outcome:
    """Return a refusal."""
    return kind(successful=False, reason=reason)
