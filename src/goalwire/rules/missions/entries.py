"""What a mission's journal is made of: steps with their keys, and entries that say what became of them."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from enum import StrEnum
from hashlib import sha256
from typing import TypeAlias
from uuid import UUID, uuid5

from goalwire.records import record

Json: TypeAlias = 'Mapping[str, Json] | Sequence[Json] | str | int | float | bool | None'
"""A value that a journal keeps as text."""


class MissionState(StrEnum):
    """Where a mission stands, as `goalwire mission list` shows it."""

    RUNNING = 'running'
    PAUSED = 'paused'
    """No further step begins until somebody resumes it; a step that has begun goes on."""
    HELD = 'held'
    """It waits for somebody to say, after a restart, that the robot may move."""
    LOST = 'lost step'
    """A step may have happened, or not: somebody has to look and decide."""
    APPROVAL = 'approval'
    """It waits for the answer to a question of its own."""
    STUCK = 'stuck'
    """Its code does not fit its journal."""
    SUCCEEDED = 'succeeded'
    FAILED = 'failed'
    CANCELED = 'canceled'

    @property
    def is_open(self) -> bool:
        """True if a runner takes the mission up at its start."""
        return self not in {MissionState.SUCCEEDED, MissionState.FAILED, MissionState.CANCELED}

    @property
    def waits_for_somebody(self) -> bool:
        """True if the mission goes on only when a person says something."""
        return self in _FOR_PEOPLE


_FOR_PEOPLE = {
    MissionState.PAUSED,
    MissionState.HELD,
    MissionState.LOST,
    MissionState.APPROVAL,
    MissionState.STUCK,
}


class Decision(StrEnum):
    """What a person, or a mission's `if_lost`, says about a step that may have happened."""

    DONE = 'done'
    """It happened: the mission goes on, with an empty result."""
    AGAIN = 'again'
    """Do it again, under a new goal id."""
    FAIL = 'fail'
    """The step fails with StepLost, and what the mission does about failures begins."""


class EntryKind(StrEnum):
    """What an entry of a journal says."""

    INTENT = 'intent'
    """A step is about to begin. Nothing was sent yet that is not in the journal."""
    CANCEL = 'cancel'
    """Its goal is about to be cancelled, by the mission itself."""
    ASKED = 'asked'
    """A person is asked, by a lost step or an approval."""
    ANSWERED = 'answered'
    ENDED = 'ended'
    """The step has ended; a mission that is started again takes its outcome from here."""
    STOP = 'stop'
    """The mission is to be stopped: somebody cancels it, or its time is over."""
    NOTE = 'note'
    """For people alone: held, paused, resumed, stuck."""


@record
class Entry:
    """One entry of a journal."""

    kind: EntryKind
    step: int
    """The step that it is about, counted from 0; -1 if it is about the mission as a whole."""
    body: Mapping[str, Json]
    data: bytes = b''
    """A message in CDR: of the request with an intent, of the result with an end."""
    at: float = 0.0
    """When it was written, by the system's clock, in s since 1970."""


@record
class StepKey:
    """What a mission's code asks for at one step."""

    kind: str
    """'goal', 'call', 'wait', 'sleep', 'approve', 'run', …"""
    target: str
    """The name of the action, service or topic, or of the function."""
    digest: str
    """A short hash of the arguments."""

    def __str__(self) -> str:
        return f'{self.kind} {self.target}'.rstrip()

    @property
    def facts(self) -> dict[str, Json]:
        """What the entries that begin or end the step say of it."""
        return {'kind': self.kind, 'target': self.target, 'digest': self.digest}


def digest_of(*parts: bytes | str) -> str:
    """Return a short hash of a step's arguments; equal arguments have equal hashes on every machine."""
    found = sha256()
    for part in parts:
        data = part if isinstance(part, bytes) else part.encode()
        found.update(len(data).to_bytes(8, 'little') + data)
    return found.hexdigest()[:16]


def goal_id_of(journal: str, mission: str, step: int, attempt: int) -> UUID:
    """Return the id of a goal: the same each time that it is asked for, and no other goal's.

    `journal` is the UUID of the journal's file: a mission that is begun anew in another file is not
    mistaken for the earlier one by a server that still knows its goals. Each 'again' counts `attempt` up.
    """
    return uuid5(UUID(journal), f'{mission}\0{step}\0{attempt}')
