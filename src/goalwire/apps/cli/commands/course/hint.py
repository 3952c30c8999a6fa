"""goalwire course hint: one hint at a time, the gentlest first."""

from __future__ import annotations

from argparse import ArgumentParser, Namespace
from typing import TYPE_CHECKING

from goalwire.apps.cli.commands.course.choosing import add_exercise_argument, find_exercise
from goalwire.apps.cli.framework.outcome import CommandError, Outcome

if TYPE_CHECKING:
    from goalwire.apps.cli.framework.output import Output


def add_arguments(parser: ArgumentParser) -> None:
    """Add the arguments of `course hint`."""
    add_exercise_argument(parser)
    parser.add_argument('which', nargs='?', type=int, default=1, help='The number of the hint (default: 1)')


def run(arguments: Namespace, output: Output) -> None:
    """Print one hint."""
    exercise = find_exercise(arguments)
    hints = exercise.hints()
    if not 1 <= arguments.which <= len(hints):
        raise CommandError(
            Outcome.NOT_FOUND,
            f'{arguments.prog}: exercise {exercise.number} has no hint {arguments.which}',
            f'it has {len(hints)}; after the last one there is: goalwire course solution {exercise.number}',
        )
    text = hints[arguments.which - 1]
    if output.json:
        output.data({'exercise': exercise.number, 'hint': arguments.which, 'of': len(hints), 'text': text})
        return
    output.line(f'{arguments.which} of {len(hints)}: {text}')
    if arguments.which < len(hints):
        output.line(f'next: goalwire course hint {exercise.number} {arguments.which + 1}', style='dim')
