"""The dry replay of a mission: its code runs against its journal, and no step is carried out.

`goalwire mission check` tells so whether changed code fits the open missions.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from goalwire.missions.steps import Perform, Steps
from goalwire.rules.missions.replay import DoesNotFit, Replay, StepHistory

if TYPE_CHECKING:
    from collections.abc import Sequence

    from goalwire.missions.definition import Definition
    from goalwire.missions.journal_store import MissionRow
    from goalwire.missions.outcomes import Outcome
    from goalwire.rules.missions.entries import Entry


class _JournalIsOver(BaseException):
    """Ends the check: the code has come to a step that has not ended, and would have to be carried out."""


class _Nobody:
    """A performer that carries out no step."""

    async def perform(
        self,
        history: StepHistory,  # noqa: ARG002
        how: Perform,  # noqa: ARG002
        *,
        is_undoing: bool,  # noqa: ARG002
        always_begins: bool,  # noqa: ARG002
    ) -> Outcome:
        raise _JournalIsOver


async def why_stuck(row: MissionRow, definition: Definition, entries: Sequence[Entry]) -> str:
    """Return why a mission's code does not fit its journal; '' if it does. Nothing is sent or written."""
    replay = Replay(entries)
    try:
        await definition(Steps(row.id, _Nobody(), replay), *row.arguments)
        replay.finish()
    except DoesNotFit as error:
        return str(error)
    except _JournalIsOver:
        return ''
    except Exception as error:
        try:
            replay.finish()
        except DoesNotFit as misfit:
            return f'{misfit}: it raises {type(error).__name__}: {error}'
    return ''
