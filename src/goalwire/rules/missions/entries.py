"""The parts of a mission's journal: steps with their keys, and entries that tell the course of each step."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from enum import StrEnum
from hashlib import sha256
from typing import TypeAlias
from uuid import UUID, uuid5

from goalwire.records import record

Json: TypeAlias = 'Mapping[str, Json] | Sequence[Json] | str | int | float | bool | None'
"""A value that a mission's journal stores as JSON text."""


class MissionState(StrEnum):
    """The state of a mission, as `goalwire mission list` shows it."""

    RUNNING = 'running'
    QUEUED = 'queued'
    """The mission waits for its turn: its runner carries out one mission at a time."""
    PAUSED = 'paused'
    """Paused: no further step begins until a person resumes the mission. A step that has begun goes on."""
    HELD = 'held'
    """After a restart, the mission waits until a person confirms that the robot may move."""
    LOST = 'lost step'
    """A step may have happened or not, and a person has to look and decide."""
    APPROVAL = 'approval'
    """The mission has asked a person for approval, and waits for the answer."""
    STUCK = 'stuck'
    """The mission's code does not fit its journal."""
    SUCCEEDED = 'succeeded'
    FAILED = 'failed'
    CANCELED = 'canceled'

    @property
    def is_open(self) -> bool:
        """True if a runner continues the mission when the runner starts."""
        return self not in {MissionState.SUCCEEDED, MissionState.FAILED, MissionState.CANCELED}

    @property
    def waits_for_somebody(self) -> bool:
        """True if the mission goes on only after a person has decided or answered."""
        return self in _FOR_PEOPLE


_FOR_PEOPLE = {
    MissionState.PAUSED,
    MissionState.HELD,
    MissionState.LOST,
    MissionState.APPROVAL,
    MissionState.STUCK,
}


class Decision(StrEnum):
    """A decision about a step that may have happened, made by a person or by a mission's `if_lost`."""

    DONE = 'done'
    """The step has happened: the mission goes on, with an empty result."""
    AGAIN = 'again'
    """Do the step again, under a new goal id."""
    FAIL = 'fail'
    """The step fails with StepLost, which the mission's own error handling may catch."""


class EntryKind(StrEnum):
    """The kind of an entry in a journal."""

    INTENT = 'intent'
    """A step is about to begin. The journal has this entry before anything of the step is sent."""
    CANCEL = 'cancel'
    """The mission itself is about to cancel the goal of the step."""
    ASKED = 'asked'
    """A person was asked, because a step was lost or needs an approval."""
    ANSWERED = 'answered'
    ENDED = 'ended'
    """The step has ended. After a restart the mission takes the outcome of the step from this entry."""
    STOP = 'stop'
    """The mission is to be stopped, because it was cancelled or its time is over."""
    NOTE = 'note'
    """An entry that only people read: held, paused, resumed, stuck."""


@record
class Entry:
    """One entry of a journal."""

    kind: EntryKind
    step: int
    """The number of the step, counted from 0; -1 if the entry concerns the mission as a whole."""
    body: Mapping[str, Json]
    data: bytes = b''
    """A message in CDR: the request in an intent, the result in an end."""
    at: float = 0.0
    """The time of writing, by the system's clock, in s since 1970."""


@record
class StepKey:
    """The kind and target of a mission's step, with a hash of its arguments."""

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
        """The fields with which the journal's entries describe the step."""
        return {'kind': self.kind, 'target': self.target, 'digest': self.digest}


def digest_of(*parts: bytes | str) -> str:
    """Return a short hash of a step's arguments; equal arguments have equal hashes on every machine."""
    found = sha256()
    for part in parts:
        data = part if isinstance(part, bytes) else part.encode()
        found.update(len(data).to_bytes(8, 'little') + data)
    return found.hexdigest()[:16]


def goal_id_of(journal: str, mission: str, step: int, attempt: int) -> UUID:
    """Return the id of a step's goal: always the same id for the same arguments, and another for others.

    `journal` is the UUID of the journal's file. So a server that still knows the goals of an earlier journal
    does not confuse a new mission's goals with them. Each decision 'again' increments `attempt`.
    """
    return uuid5(UUID(journal), f'{mission}\0{step}\0{attempt}')
