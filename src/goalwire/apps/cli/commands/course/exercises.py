"""goalwire course: its verbs, which work on the exercises of `apps/course`."""

from __future__ import annotations

from argparse import ArgumentParser, Namespace
from pathlib import Path
from typing import TYPE_CHECKING

from goalwire.apps.cli.framework.outcome import CommandError, Outcome
from goalwire.apps.course.exercises import EXERCISES, Exercise, start

if TYPE_CHECKING:
    from goalwire.apps.cli.framework.output import Output


def add_arguments(parser: ArgumentParser) -> None:
    """Add the number of an exercise, which all verbs but `list` take."""
    parser.add_argument('exercise', help=f'Its number, 1 to {len(EXERCISES)}')


def add_list_exercises_arguments(_parser: ArgumentParser) -> None:
    """Add no arguments: `course list` has none."""


def list_exercises(_arguments: Namespace, output: Output) -> None:
    """List them."""
    for exercise in EXERCISES:
        output.show(
            {'number': exercise.number, 'title': exercise.title, 'program': exercise.program},
            f'{exercise.number}  {exercise.title}: {exercise.program}',
        )
    if not output.json:
        output.line('next: goalwire course start 1')


def add_start_exercise_arguments(parser: ArgumentParser) -> None:
    """Add the arguments of `course start`."""
    add_arguments(parser)
    parser.add_argument(
        '--destination-directory', default='.', help='Where its folder is made (default: here)'
    )


def start_exercise(arguments: Namespace, output: Output) -> None:
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


def add_check_program_arguments(parser: ArgumentParser) -> None:
    """Add the arguments of `course check`."""
    add_arguments(parser)
    parser.add_argument(
        'file',
        nargs='?',
        type=Path,
        help="Your program (default: the exercise's file, here or in its folder)",
    )


def check_program(arguments: Namespace, output: Output) -> Outcome:
    """Check a program; FAILED if something is wrong."""
    exercise = find_exercise(arguments)
    file = arguments.file or _find(exercise)
    if not file.is_file():
        raise CommandError(
            Outcome.NOT_FOUND,
            f'{arguments.prog}: there is no {str(file)!r}',
            f'name your program, or begin with: goalwire course start {exercise.number}',
        )
    from goalwire.apps.course.checking import check

    def tell(step: str) -> None:
        if not output.json:
            output.line(f'ok     {step}', style='green')
            output.flush()

    report = check(exercise, file, tell)
    if output.json:
        output.data(
            {
                'exercise': exercise.number,
                'passed': report.passed,
                'problem': report.problem,
                'advice': report.advice,
            }
        )
    elif report.problem:
        output.line(f'wrong  {report.problem}', style='red')
        output.block(f'       {report.advice}')
        output.line(f'next: mend {file}, then check again; goalwire course hint {exercise.number} helps')
    else:
        output.line(f'exercise {exercise.number} is done: {exercise.title}', style='bold')
    return Outcome.FAILED if report.problem else Outcome.OK


def _find(exercise: Exercise) -> Path:
    """Return the exercise's program in the working directory, or else in the exercise's folder below it."""
    here = Path(exercise.program)
    return here if here.is_file() else Path(exercise.folder, exercise.program)


def add_show_hint_arguments(parser: ArgumentParser) -> None:
    """Add the arguments of `course hint`."""
    add_arguments(parser)
    parser.add_argument('which', nargs='?', type=int, default=1, help='The number of the hint (default: 1)')


def show_hint(arguments: Namespace, output: Output) -> None:
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


def show_solution(arguments: Namespace, output: Output) -> None:
    """Print only the program, so that the output can be redirected into a file."""
    output.block(find_exercise(arguments).read('solution.py'), end='')


def find_exercise(arguments: Namespace) -> Exercise:
    """Return the exercise with the given number. Raises CommandError if no exercise has it."""
    for exercise in EXERCISES:
        if str(exercise.number) == arguments.exercise:
            return exercise
    raise CommandError(
        Outcome.NOT_FOUND,
        f'{arguments.prog}: there is no exercise {arguments.exercise!r}',
        f'choose 1 to {len(EXERCISES)}; see: goalwire course list',
    )
