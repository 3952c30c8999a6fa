"""The journal of an action server: its settings, its record of a goal, and texts about it for clients.

An action server of ROS 2 forgets all goals when its process ends, and each ended goal after a while. Then it
executes a goal with the same id again, and answers UNKNOWN for a goal that it has half executed. A server
with a journal does neither. It tells its clients more than ROS 2's messages can, by a text behind the result
(rules/goals/wire.py). Clients of ROS 2 do not see the text; the status that they read is true as well.
"""

from __future__ import annotations

from os import PathLike
from typing import TYPE_CHECKING

from goalwire.records import record
from goalwire.rules.goals.states import GoalStatus

if TYPE_CHECKING:
    from pathlib import Path

RESULTS = 1000
AGE_S = 7 * 24 * 3600.0

SERVER_DIED = 'it was begun, then its server died'
"""The text behind the result of a goal that an earlier process has accepted and not ended. It is ABORTED."""
RESULT_DROPPED = 'its result is not kept any more'
"""The text behind the empty result of a goal whose own one the journal has dropped."""
_JOURNAL = 'not in the journal '


@record
class GoalJournal:
    """A journal for an action server: `journal=GoalJournal('drive.goals', results=100)`."""

    path: str | PathLike[str]
    """The file, which belongs to one server. It is made if it does not exist."""
    results: int = RESULTS
    """The number of goals, the newest ones, whose results are kept. Ids and statuses are kept for ever."""
    age: float = AGE_S
    """The time in s for which results are kept at most."""

    def __post_init__(self) -> None:
        if self.results < 0 or self.results != int(self.results):
            raise ValueError(f'a journal keeps a number of results, 0 or more, not {self.results!r}')
        if not self.age >= 0:  # nan, too
            raise ValueError(f'a journal keeps results for a number of seconds, 0 or more, not {self.age!r}')


@record
class KnownGoal:
    """The record of a goal in a journal."""

    status: GoalStatus
    """UNKNOWN while it is under way in this process."""
    result: bytes | None
    """Its serialized get_result reply; b'' for the type's default. None: it is not kept any more."""
    server_died: bool = False
    """True if an earlier process has accepted it, and died before its end."""


def read_journal(given: str | Path | GoalJournal) -> GoalJournal:
    """Return the journal that a program gives as a path or as a GoalJournal.

    Raises TypeError for other types.
    """
    if isinstance(given, GoalJournal):
        return given
    if isinstance(given, str | PathLike):
        return GoalJournal(given)
    raise TypeError(f'journal is the path of a file or a goalwire.GoalJournal, not {type(given).__name__}')


def absence_text(journal: str) -> str:
    """Return the text beside the status UNKNOWN of a goal that the journal with this id does not have."""
    return _JOURNAL + journal


def journal_in(text: str) -> str:
    """Return the journal's id in a text made by `absence_text`; '' if the text is a different one."""
    return text.removeprefix(_JOURNAL) if text.startswith(_JOURNAL) else ''
