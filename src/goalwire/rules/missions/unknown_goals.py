"""Judges whether a goal that is unknown to its server never arrived there, or was forgotten by it.

The server gives the same answer in both cases. But every goal that ends changes the server's status array,
and a server keeps results for a while. So the array from before the goal was sent is compared with the
present array. The rules and their sources (rcl, rclpy, rclcpp) are in docs/explanation/missions.md.
"""

from __future__ import annotations

from enum import Enum

from goalwire.rules.goals.server_snapshot import ServerSnapshot

KEPT_S = 10.0
"""The time in s for which servers keep results at least: rcl's default since Iron."""
NEWCOMER_S = 5.0
"""The time in s after which a new client has got an earlier status array. Fast DDS took 0.5 to 3 s."""


class Whereabouts(Enum):
    """The fate of a goal that the server does not know."""

    NEVER_ARRIVED = 'never arrived'
    """The goal did not run: it never arrived, or it was refused. It may be sent again with the same id."""
    LOST = 'lost'
    """The goal may have run, wholly or in part."""
    TOO_EARLY = 'too early'
    """The server's status array may still be on its way: ask again."""


def judge(
    sent: ServerSnapshot | None,
    now: ServerSnapshot,
    *,
    listened: float,
    age: float | None,
    kept: float = KEPT_S,
) -> tuple[Whereabouts, str]:
    """Return the fate of a goal that the server does not know, and the reason in a sentence.

    `sent` is a snapshot of the server from just before the goal was sent, `now` is one of now. All times are
    in s. `listened`: the time for which this client has heard the server. `age`: the time since the goal was
    sent, by a clock that does not jump; None if the machine was restarted meanwhile. `kept`: the time for
    which the server keeps results.
    """
    if sent is None or not sent.servers or sent.servers != now.servers:
        return Whereabouts.LOST, 'the server was restarted since, and has forgotten its goals'
    if sent.statuses == now.statuses and (now.statuses or listened >= NEWCOMER_S):
        return Whereabouts.NEVER_ARRIVED, 'no goal has ended at the server since'
    if age is not None and age < kept:
        return Whereabouts.NEVER_ARRIVED, f'the server would still have its result {age:.1f} s later'
    if not now.statuses and listened < NEWCOMER_S:
        return Whereabouts.TOO_EARLY, "the server's status array may still be on its way"
    return Whereabouts.LOST, 'it may have ended, and the server has forgotten it'
