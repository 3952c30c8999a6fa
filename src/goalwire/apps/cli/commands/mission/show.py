"""goalwire mission show: prints a mission's state, its open question, and the command to answer it."""

from __future__ import annotations

from argparse import ArgumentParser, Namespace
from typing import TYPE_CHECKING

from goalwire.apps.cli.commands.mission.journals import add_mission_arguments, find_mission, open_journal

if TYPE_CHECKING:
    from goalwire.apps.cli.framework.output import Output
    from goalwire.missions.store import MissionRow


def add_arguments(parser: ArgumentParser) -> None:
    """Add the arguments of `mission show`."""
    add_mission_arguments(parser)


def run(arguments: Namespace, output: Output) -> None:
    """Print the mission; raises CommandError."""
    from goalwire.apps.cli.commands.mission.showing import clock_time, row_data

    with open_journal(arguments) as store:
        row = find_mission(store, arguments.mission_id)
    if output.json:
        output.data(row_data(row))
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
    if row.state.waits_for_somebody:
        output.line(f'Next: {next_command(row)}')


def next_command(row: MissionRow) -> str:
    """Return the command by which the user answers a waiting mission."""
    from goalwire.rules.missions.entries import MissionState

    if row.state is MissionState.LOST:
        return f'look at the robot, then: goalwire mission decide {row.id} done|again|fail'
    if row.state is MissionState.APPROVAL:
        return f'goalwire mission approve {row.id} yes|no'
    if row.state is MissionState.STUCK:
        return f'run the code that fits, or: goalwire mission cancel {row.id}'
    return f'look at the robot, then: goalwire mission resume {row.id}'
