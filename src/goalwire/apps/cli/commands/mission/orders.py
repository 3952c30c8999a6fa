"""goalwire mission approve, cancel, decide, pause and resume: what somebody tells a mission."""

from __future__ import annotations

from argparse import ArgumentParser, Namespace
from typing import TYPE_CHECKING

from goalwire.apps.cli.commands.mission.journals import (
    add_mission_arguments,
    find_mission,
    open_journal,
)
from goalwire.apps.cli.framework.outcome import CommandError, Outcome

if TYPE_CHECKING:
    from collections.abc import Mapping

    from goalwire.apps.cli.framework.output import Output
    from goalwire.missions.journal_store import MissionRow, Store
    from goalwire.rules.missions.entries import Json


def add_arguments(parser: ArgumentParser) -> None:
    """Add the arguments of `mission pause` and `mission resume`."""
    add_mission_arguments(parser)


def add_approve_arguments(parser: ArgumentParser) -> None:
    """Add the arguments of `mission approve`."""
    add_mission_arguments(parser)
    parser.add_argument(
        'answer', nargs='?', choices=('yes', 'no'), default='yes', help='The answer (default: yes)'
    )


def approve(arguments: Namespace, _output: Output) -> None:
    """Leave the answer for the runner; raises CommandError."""
    _answer(arguments, 'approve')


def add_cancel_arguments(parser: ArgumentParser) -> None:
    """Add the arguments of `mission cancel`."""
    add_mission_arguments(parser)
    parser.add_argument('--no-undo', action='store_true', help='Run no undo steps')


def cancel(arguments: Namespace, _output: Output) -> None:
    """Tell the runner to cancel the mission's goal and to run its undo steps. Raises CommandError."""
    _leave(arguments, 'cancel', undo=not arguments.no_undo)


def add_decide_arguments(parser: ArgumentParser) -> None:
    """Add the arguments of `mission decide`."""
    add_mission_arguments(parser)
    parser.add_argument(
        'answer',
        choices=('done', 'again', 'fail'),
        help='done: it happened, go on; again: do it again; fail: it failed, and undo steps may run',
    )


def decide(arguments: Namespace, _output: Output) -> None:
    """Leave the decision for the runner; raises CommandError."""
    _answer(arguments, 'decide')


def pause(arguments: Namespace, _output: Output) -> None:
    """Let no further step begin; the current one goes on. Raises CommandError."""
    _leave(arguments, 'pause')


def resume(arguments: Namespace, _output: Output) -> None:
    """Let a mission go on that is paused, held after a restart, or stuck. Raises CommandError."""
    _leave(arguments, 'resume')


def _leave(arguments: Namespace, verb: str, **body: Json) -> None:
    with open_journal(arguments) as store:
        _leave_command(store, find_mission(store, arguments.mission_id), verb, body)


def _answer(arguments: Namespace, verb: str) -> None:
    """Leave the answer to a question. Raises CommandError if there is no such question."""
    from goalwire.errors import MissionError
    from goalwire.missions.questions import answer_body

    with open_journal(arguments) as store:
        row = find_mission(store, arguments.mission_id)
        try:
            body = answer_body(verb, arguments.answer, row.state, store.entries(row.id))
        except MissionError as error:
            see = f'see: goalwire mission show {row.id}'
            raise CommandError(Outcome.REFUSED, f"mission '{row.id}': {error}", see) from None
        _leave_command(store, row, verb, body)


def _leave_command(store: Store, row: MissionRow, verb: str, body: Mapping[str, Json]) -> None:
    """Put a command into the journal, and wake its runner. Raises CommandError if the mission has ended."""
    from goalwire.missions.wakeup import wake_runner

    if not row.state.is_open:
        raise CommandError(Outcome.REFUSED, f"mission '{row.id}' has ended: {row.state}")
    store.command(row.id, verb, body)
    wake_runner(store)
