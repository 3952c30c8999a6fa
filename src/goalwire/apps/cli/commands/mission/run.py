"""goalwire mission run: begins or continues a mission of a file, and follows it until it ends."""

from __future__ import annotations

from argparse import ArgumentParser, Namespace
from typing import TYPE_CHECKING, Any

import goalwire
from goalwire.apps.cli.commands.mission.definitions import missions_in
from goalwire.apps.cli.commands.mission.journals import add_journal_argument
from goalwire.apps.cli.framework.live import live
from goalwire.apps.cli.framework.outcome import CommandError, Outcome
from goalwire.apps.cli.framework.output import tell
from goalwire.errors import JournalError, MissionFailed, MissionIdTaken

if TYPE_CHECKING:
    from goalwire.apps.cli.framework.output import Output
    from goalwire.missions import MissionRun

_NODE = 'missions'


def add_arguments(parser: ArgumentParser) -> None:
    """Add the arguments of `mission run`."""
    add_journal_argument(parser)
    parser.add_argument('mission', metavar='FILE:NAME', help='A Python file, and the name of a mission in it')
    parser.add_argument(
        'arguments', nargs='*', metavar='ARGUMENT', help='Arguments of the mission, as YAML: 3, A3, [1, 2]'
    )
    parser.add_argument(
        '--id',
        metavar='ID',
        help='Id of the mission; a mission that has begun continues (default: a new id)',
    )


def run(arguments: Namespace, output: Output) -> Outcome:
    """Run the mission; raises CommandError."""
    from yaml import YAMLError, safe_load

    from goalwire.missions import Runner

    file, colon, name = arguments.mission.rpartition(':')
    if not colon:
        raise CommandError(Outcome.USAGE, f"'{arguments.mission}' names no mission", 'write FILE:NAME')
    definitions = missions_in(file)
    if name not in definitions:
        known = ', '.join(sorted(definitions))
        raise CommandError(Outcome.NOT_FOUND, f"'{file}' has no mission '{name}'", f'it has: {known}')
    try:
        given = [safe_load(each) for each in arguments.arguments]
    except YAMLError as error:
        raise CommandError(Outcome.BAD_VALUE, f'an argument is not YAML: {error}') from None

    async def follow(node: goalwire.Node) -> Outcome:
        try:
            async with Runner(node, arguments.journal, missions=definitions.values()) as runner:
                begun = await runner.start(definitions[name], *given, id=arguments.id)
                return await _show(begun, output)
        except (MissionIdTaken, TypeError) as error:
            raise CommandError(Outcome.BAD_VALUE, str(error)) from None
        except JournalError as error:
            raise CommandError(Outcome.UNAVAILABLE, str(error)) from None

    return live(follow, _NODE)


async def _show(run: MissionRun, output: Output) -> Outcome:
    """Print the journal as it is written, and how the mission ends."""
    from goalwire.apps.cli.commands.mission.looking import next_command, show_entry
    from goalwire.missions import MissionState
    from goalwire.records import replace

    mission = run.row.id
    if not output.json:
        output.line(f'Mission: {mission}')
    told = ''
    try:
        async for entry in run.journal():
            show_entry(entry, output)
            if run.state.waits_for_somebody and run.why != told:
                told = run.why
                tell(f'{run.why}\n{next_command(replace(run.row, state=run.state))}')
        result: Any = await run.wait()
    except MissionFailed as error:
        code = Outcome.CANCELED if run.state is MissionState.CANCELED else Outcome.ABORTED
        raise CommandError(code, str(error)) from None
    output.show(
        {'id': mission, 'state': str(run.state), 'result': result},
        f'Mission {run.state}{"" if result is None else f": {result}"}',
    )
    return Outcome.OK
