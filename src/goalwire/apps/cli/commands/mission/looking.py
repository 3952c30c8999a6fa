"""goalwire mission history, list and show: what a journal says; no runner is needed."""

from __future__ import annotations

from argparse import ArgumentParser, Namespace
from datetime import datetime
from typing import TYPE_CHECKING

from goalwire.apps.cli.commands.mission.journals import (
    add_journal_argument,
    add_mission_arguments,
    find_mission,
    open_journal,
)
from goalwire.rules.missions.entries import EntryKind, MissionState

if TYPE_CHECKING:
    from collections.abc import Mapping

    from goalwire.apps.cli.framework.output import Json, Output
    from goalwire.missions.journal_store import MissionRow
    from goalwire.rules.missions.entries import Entry


_STYLES = {
    MissionState.RUNNING: 'cyan',
    MissionState.SUCCEEDED: 'green',
    MissionState.FAILED: 'red',
    MissionState.CANCELED: 'yellow',
}


def add_arguments(parser: ArgumentParser) -> None:
    """Add the arguments of `mission history` and `mission show`."""
    add_mission_arguments(parser)


def show_history(arguments: Namespace, output: Output) -> None:
    """Print the entries in the order in which they were written; raises CommandError."""
    with open_journal(arguments) as store:
        for entry in store.entries(find_mission(store, arguments.mission_id).id):
            show_entry(entry, output)


def add_list_missions_arguments(parser: ArgumentParser) -> None:
    """Add the arguments of `mission list`."""
    add_journal_argument(parser)
    parser.add_argument('--open', action='store_true', help='Only missions that have not ended')


def list_missions(arguments: Namespace, output: Output) -> None:
    """Print the missions in the order in which they began; raises CommandError."""
    from goalwire.missions.file_lock import has_runner

    with open_journal(arguments) as store:
        rows = [row for row in store.missions() if row.state.is_open or not arguments.open]
    is_run = has_runner(arguments.journal)
    for row in rows:
        if output.json:
            output.data(row_data(row) | {'has_runner': is_run})
            continue
        state = output.style(f'{row.state:10}', state_style(row.state))
        runner = '' if is_run or not row.state.is_open else '; nobody runs it'
        why = f'  {row.why}' if row.why else ''
        output.block(f'{row.id}  {state}  {row.name}  since {clock_time(row.begun)}{runner}{why}')


def show_mission(arguments: Namespace, output: Output) -> None:
    """Print the mission; raises CommandError."""
    from goalwire.missions.file_lock import has_runner

    with open_journal(arguments) as store:
        row = find_mission(store, arguments.mission_id)
    is_run = has_runner(arguments.journal)
    if output.json:
        output.data(row_data(row) | {'has_runner': is_run})
        return
    output.line(f'Mission: {row.id}')
    output.line(f'Code: {row.name}, version {row.version}')
    output.line(f'Arguments: {" ".join(map(str, row.arguments)) or "none"}')
    output.line(f'Begun: {clock_time(row.begun)}')
    output.line(f'State: {row.state}, since {clock_time(row.changed)}')
    if row.why:
        output.line(f'Why: {row.why}')
    if row.result is not None:
        output.line(f'Result: {row.result}')
    if row.state.is_open and not is_run:
        output.line('Runner: none; the mission goes on when its runner is started')
    if row.state.waits_for_somebody:
        output.line(f'Next: {next_command(row)}')


def next_command(row: MissionRow) -> str:
    """Return the command by which the user answers a waiting mission."""
    if row.state is MissionState.LOST:
        return f'look at the robot, then: goalwire mission decide {row.id} done|again|fail'
    if row.state is MissionState.APPROVAL:
        return f'goalwire mission approve {row.id} yes|no'
    if row.state is MissionState.STUCK:
        return f'run the code that fits, or: goalwire mission cancel {row.id}'
    return f'look at the robot, then: goalwire mission resume {row.id}'


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
    if body.get('kind') == 'send':
        return 'accepted'
    value = body.get('value')
    return 'done' if value is None else f'gave {value}'
