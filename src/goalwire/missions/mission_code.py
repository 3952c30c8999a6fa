"""Runs a mission's code from its beginning, and returns how it ended."""

from __future__ import annotations

import traceback
from typing import TYPE_CHECKING, Any

from goalwire.errors import MissionStopped
from goalwire.missions.journal_store import Change, as_json
from goalwire.missions.steps import Performer, Steps
from goalwire.rules.missions.entries import Entry, EntryKind, MissionState
from goalwire.rules.missions.replay import DoesNotFit, Replay

if TYPE_CHECKING:
    from goalwire.missions.mission_run_contract import RunningMission


async def run_code(run: RunningMission, performer: Performer) -> Change:
    """Run the code once, and return the change to write. Ended steps take their outcomes from the journal."""
    id_ = run.row.id
    replay = Replay(run.entries())
    value: Any = None
    try:
        value, error = await _call_code(run, Steps(id_, performer, replay))
        replay.finish()
    except DoesNotFit as misfit:
        return _stuck(run, misfit)
    stop = run.stop
    is_canceled = stop is not None and stop.body.get('by') == 'cancel'
    if error is None and not is_canceled:
        return Change(id_, state=MissionState.SUCCEEDED, result=value)
    state = MissionState.CANCELED if is_canceled else MissionState.FAILED
    why = '' if stop is None else str(stop.body['why'])
    if error is not None:
        kind = '' if isinstance(error, MissionStopped) else f'{type(error).__name__}: '
        why = kind + '; '.join([str(error), *getattr(error, '__notes__', ())])
    return Change(id_, state=state, why=why, result=value)


async def _call_code(run: RunningMission, steps: Steps) -> tuple[Any, Exception | None]:
    """Return the outcome of the mission's function: a value or an error."""
    try:
        value = await run.definition(steps, *run.row.arguments)
        as_json(value)
    except MissionStopped as stopped:
        return None, stopped
    except Exception as error:
        trace = ''.join(traceback.format_exception(error))
        run.node.logger.error(f'Mission {run.row.id} failed\n{trace}')
        return None, error
    return value, None


def _stuck(run: RunningMission, misfit: DoesNotFit) -> Change:
    now, then = run.definition, run.row
    code = 'the code is the same'
    if now.fingerprint != then.fingerprint:
        code = f'the code was changed (version {then.version} to {now.version})'
    why = f'{misfit}; {code}'
    note = Entry(EntryKind.NOTE, -1, {'text': f'stuck: {why}'})
    return Change(run.row.id, (note,), MissionState.STUCK, why)
