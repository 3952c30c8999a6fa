"""Decides whether the robot is stopped, by the publishers of `emergency_stopped`. Does not import ROS.

A *switch* is a publisher whose node has the service `emergency_stop`, too. A switch repeats its state, so its
silence is noticed. Any other publisher is a *stranger*: a console, a recording, a second program. The rules:

- A publisher that says "stopped" stops the robot, until the same publisher says "released".
- A "released" never cancels the "stopped" of another publisher. So one "stopped" is enough.
- The robot stops if a switch falls silent, or if a stranger that said "stopped" disappears. It stays stopped
  until a switch was thrown and released.
- A stranger's "released" only takes back its own "stopped".
"""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import dataclass
from typing import NamedTuple

MISSED = 5  # repetitions that a switch may miss; after 1 s it counts as gone
GONE = 'its switch is gone: is joint_state_service running?'


class Publisher(NamedTuple):
    """A publisher of `emergency_stopped`."""

    gid: bytes  # the publisher's id; b'' if it could be any of several
    node: str  # the node's name, or a phrase that names the possible nodes
    is_switch: bool
    is_latched: bool | None = None  # whether its QoS is transient local; None if unknown


@dataclass
class Vote:
    """A publisher's last state, "stopped" or "released". A stranger's vote is kept only while "stopped"."""

    publisher: Publisher
    stopped: bool
    missed: int = 0


class StopVotes:
    """The last state of each publisher, and whether these states stop the robot."""

    def __init__(self) -> None:
        self.lost = ''
        """Why the robot stays stopped after a publisher was lost; '' if no publisher was lost."""
        self._votes: dict[bytes, Vote] = {}

    @property
    def knows_switch(self) -> bool:
        """True if a switch has been heard."""
        return bool(self.lost) or any(vote.publisher.is_switch for vote in self._votes.values())

    @property
    def stopped_by(self) -> Publisher | None:
        """A publisher that says "stopped", a stranger first: the service cannot release a stranger's stop."""
        stopping = [vote.publisher for vote in self._votes.values() if vote.stopped]
        return min(stopping, key=lambda publisher: publisher.is_switch, default=None)

    @property
    def stopped(self) -> bool:
        return bool(self.lost) or self.stopped_by is not None

    def hear(self, publisher: Publisher, *, stopped: bool) -> bool:
        """Record a publisher's "stopped" or "released"; return True if a switch must be thrown as a result.

        This happens if a switch says "released" without knowing of a stop: because another switch was lost,
        or because this switch has just been started.
        """
        before = self._votes.get(publisher.gid)
        if stopped:
            self._votes[publisher.gid] = Vote(publisher, stopped=True)
            if publisher.is_switch:
                self.lost = ''  # this switch keeps the robot stopped from now on, and has to be released
            return False
        if not publisher.is_switch:
            if publisher.gid:
                self._votes.pop(publisher.gid, None)
            return False
        throw = bool(self.lost) or (before is None and self.stopped)
        self._votes[publisher.gid] = Vote(publisher, stopped=False)
        return throw

    def look(self, present: Collection[bytes]) -> bool:
        """Return True if a publisher was lost; `present` has the gids of the present publishers.

        A switch is lost after several calls without its repetition. Seconds are not counted: a program that
        was suspended would otherwise take every switch for lost.
        """
        lost = ''
        for gid, vote in list(self._votes.items()):
            vote.missed += 1
            silent = vote.missed > MISSED
            if vote.publisher.is_switch and silent:
                lost = GONE
                del self._votes[gid]
            elif not vote.publisher.is_switch and (gid not in present if gid else silent):
                lost = lost or f'{vote.publisher.node}, which had stopped it, is gone.'
                del self._votes[gid]
        self.lost = lost or self.lost
        return bool(lost)
