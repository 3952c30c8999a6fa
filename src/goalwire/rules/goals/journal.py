"""The journal of an action server: its settings, its memory of a goal, and the texts that tell clients of it.

A server of ROS 2 forgets its goals when it ends, and ended goals after a while. Then it executes a known id
again, and answers UNKNOWN for a goal that it has half executed. A server with a journal does neither. It
tells its clients more than ROS 2's messages can, by the text behind a result (rules/goals/wire.py). Clients
of ROS 2 do not see the text, and read a status that is true as well.
"""

from __future__ import annotations

from os import PathLike
from typing import TYPE_CHECKING

from goalwire.records import record
from goalwire.rules.goals.table import GoalStatus

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
    """A goal in a journal."""

    status: GoalStatus
    """UNKNOWN while it is under way in this process."""
    result: bytes | None
    """Its serialized get_result reply; b'' for the type's default. None: it is not kept any more."""
    server_died: bool = False
    """True if an earlier process has accepted it, and died before its end."""


def read_journal(given: str | Path | GoalJournal) -> GoalJournal:
    """Return the settings that a program gives as a path or as a GoalJournal. Raises TypeError."""
    if isinstance(given, GoalJournal):
        return given
    if isinstance(given, str | PathLike):
        return GoalJournal(given)
    raise TypeError(f'journal is the path of a file or a goalwire.GoalJournal, not {type(given).__name__}')


def absence_text(journal: str) -> str:
    """Return the text behind the UNKNOWN of a server whose journal, of this id, does not have the goal."""
    return _JOURNAL + journal


def journal_in(text: str) -> str:
    """Return the id of the journal that `absence_text` names; '' if the text is another one."""
    return text.removeprefix(_JOURNAL) if text.startswith(_JOURNAL) else ''
