"""Decides whether the robot is stopped, from all publishers of `emergency_stopped`. It knows no ROS.

A *switch* is a publisher whose node has the service `emergency_stop`, too. It repeats its state, so its
silence is noticed. Anybody else is a *stranger*: a console, a recording, a second program. The rules:

- Whoever says "stopped" stops the robot, until the same publisher says "released".
- Nobody's "released" takes back what another has said. So publishers that disagree mean stopped.
- The robot stops if a switch falls silent, or if a stranger goes away that said "stopped". It stays so until
  a switch was thrown and released.
- A stranger's "released" means nothing else.
"""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import dataclass
from typing import NamedTuple

MISSED = 5  # times that a switch was due and was not heard: after 1 s it is gone
GONE = 'its switch is gone: is joint_state_service running?'


class Publisher(NamedTuple):
    """A publisher of `emergency_stopped`."""

    gid: bytes  # b'' if it is not known which of several has published
    node: str  # or a phrase for the nodes of which one is meant
    is_switch: bool
    is_latched: bool | None = None  # None if it is not known


@dataclass
class Vote:
    """The last word of a publisher. A stranger has a vote only while it says "stopped"."""

    publisher: Publisher
    stopped: bool
    missed: int = 0


class StopVotes:
    """The last word of each publisher, and whether they stop the robot."""

    def __init__(self) -> None:
        self.lost = ''
        """Why the robot is stopped although nobody says so any more; '' if that is not so."""
        self._votes: dict[bytes, Vote] = {}

    @property
    def knows_switch(self) -> bool:
        """Whether a switch was heard so far."""
        return bool(self.lost) or any(vote.publisher.is_switch for vote in self._votes.values())

    @property
    def stopped_by(self) -> Publisher | None:
        """The publisher that says "stopped"; of several a stranger, since no service releases that."""
        stopping = [vote.publisher for vote in self._votes.values() if vote.stopped]
        return min(stopping, key=lambda publisher: publisher.is_switch, default=None)

    @property
    def stopped(self) -> bool:
        return bool(self.lost) or self.stopped_by is not None

    def hear(self, publisher: Publisher, *, stopped: bool) -> bool:
        """Take down what a publisher says; return whether a switch has to be thrown.

        That is so if a switch says "released" and cannot know better: another one was lost, or this one has
        just been started.
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
        """Return whether a publisher was lost since the last look; `present` are the gids of those there are.

        Looks are counted, not seconds: a program that had no time to look has missed nothing yet.
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
