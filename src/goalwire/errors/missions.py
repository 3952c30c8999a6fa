"""Errors of durable missions and their journals."""

from __future__ import annotations

from goalwire.errors.base import GoalwireError


class MissionError(GoalwireError):
    """The base class of the errors of durable missions and their journals."""


class JournalError(MissionError):
    """A journal cannot be opened, read or written, or another runner has opened it."""


class MissionIdTaken(MissionError, ValueError):
    """A mission with that id was started before, under another name or with other arguments."""


class MissionFailed(MissionError):
    """A mission ended without success, or was cancelled; the text says why."""


class MissionStopped(MissionError):
    """Raised in a mission's code: the mission was cancelled, gave up, or its time is over. Only steps that
    undo what was done are still started.
    """

    def __init__(self, message: str, *, undo: bool = True) -> None:
        super().__init__(message)
        self.undo = undo
        """True if the steps that undo what was done are to run."""


class StepFailed(MissionError):
    """Raised in a mission's code: a function that `m.run` called has raised an error, whose text this error
    has.
    """


class StepLost(MissionError):
    """Raised in a mission's code: nobody knows whether a step happened, and a person or rule decided that it
    counts as failed.
    """
