"""goalwire course start: a folder with the task, the interfaces, and a file to begin with."""

from __future__ import annotations

from argparse import ArgumentParser, Namespace
from pathlib import Path
from typing import TYPE_CHECKING

from goalwire.apps.cli.commands.course.choosing import add_exercise_argument, find_exercise
from goalwire.apps.cli.framework.outcome import CommandError, Outcome
from goalwire.apps.course.exercises import start

if TYPE_CHECKING:
    from goalwire.apps.cli.framework.output import Output


def add_arguments(parser: ArgumentParser) -> None:
    """Add the arguments of `course start`."""
    add_exercise_argument(parser)
    parser.add_argument(
        '--destination-directory', default='.', help='Where its folder is made (default: here)'
    )


def run(arguments: Namespace, output: Output) -> None:
    """Make the folder of an exercise; existing files are never overwritten."""
    exercise = find_exercise(arguments)
    place = Path(arguments.destination_directory)
    folder = place / exercise.folder
    try:
        files = start(exercise, place)
    except FileExistsError:
        raise CommandError(
            Outcome.FAILED,
            f'{arguments.prog}: there is a {str(folder)!r} already, and it stays as it is',
            'rename it, or choose another place with --destination-directory',
        ) from None
    if output.json:
        output.data({'folder': str(folder), 'files': [file.relative_to(folder).as_posix() for file in files]})
        return
    output.line(f'made {folder}: {exercise.title}')
    output.line(
        f'next: read {folder / "README.md"}, write {exercise.program}, then: goalwire course check '
        f'{exercise.number}'
    )
