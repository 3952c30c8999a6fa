"""Missions and their journals as text and as JSON."""

from __future__ import annotations

from datetime import datetime
from typing import TYPE_CHECKING

from goalwire.rules.missions.entries import EntryKind, MissionState

if TYPE_CHECKING:
    from collections.abc import Mapping

    from goalwire.apps.cli.framework.output import Json, Output
    from goalwire.missions.store import MissionRow
    from goalwire.rules.missions.entries import Entry

_STYLES = {
    MissionState.RUNNING: 'cyan',
    MissionState.SUCCEEDED: 'green',
    MissionState.FAILED: 'red',
    MissionState.CANCELED: 'yellow',
}


def clock_time(at: float) -> str:
    """Return a time as people read it."""
    return datetime.fromtimestamp(at).astimezone().strftime('%Y-%m-%d %H:%M:%S')


def state_style(state: MissionState) -> str:
    """Return the style of a state; states that wait for a person are bold."""
    return _STYLES.get(state, 'bold')


def row_data(row: MissionRow) -> dict[str, Json]:
    """Return a mission for `--json`."""
    return {
        'id': row.id,
        'name': row.name,
        'version': row.version,
        'arguments': list(row.arguments),
        'state': str(row.state),
        'why': row.why,
        'begun': row.begun,
        'changed': row.changed,
        'result': row.result,
    }


def entry_data(entry: Entry) -> dict[str, Json]:
    """Return an entry of a journal for `--json`."""
    return {'at': entry.at, 'entry': str(entry.kind), 'step': entry.step + 1, **entry.body}


def show_entry(entry: Entry, output: Output) -> None:
    """Print an entry of a journal on one line."""
    if output.json:
        output.data(entry_data(entry))
        return
    time = f'{clock_time(entry.at)}  ' if entry.at else ''
    step = f'step {entry.step + 1}' if entry.step >= 0 else 'mission'
    output.line(f'{time}{step}: {_text(entry)}')
    output.flush()


def _text(entry: Entry) -> str:
    body = entry.body
    what = f'{body.get("kind", "")} {body.get("target", "")}'.strip()
    match entry.kind:
        case EntryKind.INTENT:
            goal = f', goal {body["goal_id"]}' if 'goal_id' in body else ''
            return f'{what} begins{goal}'
        case EntryKind.CANCEL:
            return f'its goal is cancelled: {body["why"]}'
        case EntryKind.ASKED:
            return f'asks: {body["question"]}'
        case EntryKind.ANSWERED:
            by = f', by {body["who"]}' if 'who' in body else ''
            return f'answer: {body["answer"]}{by}'
        case EntryKind.ENDED:
            return f'{what} {_ending(body)}'
        case EntryKind.STOP:
            return f'to be stopped: {body["why"]}'
        case EntryKind.NOTE:
            return str(body['text'])


def _ending(body: Mapping[str, Json]) -> str:
    if 'error' in body:
        return f'failed: {body["error"]}: {body["text"]}'
    value = body.get('value')
    return 'done' if value is None else f'gave {value}'
