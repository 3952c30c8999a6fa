"""The outcome of setting parameters: accepted, or refused with a reason (SetParametersResult)."""

from __future__ import annotations

from typing import NamedTuple


class Outcome(NamedTuple):
    """The outcome of setting parameters: `successful`, and for a refusal the reason, a text for people."""

    successful: bool
    reason: str = ''


class WrongType(Outcome):
    """A refusal because of the value's type.

    A declaration raises a different exception for it, as in rclpy.
    """


ACCEPTED = Outcome(successful=True)


def refuse(reason: str, kind: type[Outcome] = Outcome) -> Outcome:
    """Return a refusal."""
    return kind(successful=False, reason=reason)
