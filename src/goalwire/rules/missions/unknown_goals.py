"""A goal that its server does not have: did it never arrive, or was it forgotten?

The server itself does not tell these apart. What helps is what the server showed when the goal was about to
be sent, since every goal that ends changes the server's status array, and a server keeps results for a while.
The rules and their sources (rcl, rclpy, rclcpp) are in docs/explanation/missions.md.
"""

from __future__ import annotations

from enum import Enum

from goalwire.rules.goals.server_view import ServerView

KEPT_S = 10.0
"""For how long servers keep results at least: rcl's default from Iron on."""
NEWCOMER_S = 5.0
"""How long a new client may wait for an earlier status array: 0.5 to 3 s were measured on Fast DDS."""


class Whereabouts(Enum):
    """What became of a goal that the server does not have."""

    NEVER_ARRIVED = 'never arrived'
    """Or it was refused. It did not run: it may be sent, with the same id."""
    LOST = 'lost'
    """It may have run, wholly or in part."""
    TOO_EARLY = 'too early'
    """The server's status array may still be on its way: ask again."""


def judge(
    sent: ServerView | None, now: ServerView, *, listened: float, age: float | None, kept: float = KEPT_S
) -> tuple[Whereabouts, str]:
    """Say what became of a goal that the server does not have, and why, in a sentence.

    `sent` is what was seen when the goal was about to be sent. `listened` says for how many s this client
    hears the server, `age` how many s ago the goal was about to be sent, by a clock that did not jump; None
    if the machine was restarted since. `kept` says how many s the server keeps results after a goal's end.
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
