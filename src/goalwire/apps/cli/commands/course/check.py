"""goalwire course check: runs a student's program, tests it, and prints the first mistake."""

from __future__ import annotations

from argparse import ArgumentParser, Namespace
from pathlib import Path
from typing import TYPE_CHECKING

from goalwire.apps.cli.commands.course.choosing import add_exercise_argument, find_exercise
from goalwire.apps.cli.framework.outcome import CommandError, Outcome

if TYPE_CHECKING:
    from goalwire.apps.cli.framework.output import Output
    from goalwire.apps.course.exercises import Exercise


def add_arguments(parser: ArgumentParser) -> None:
    """Add the arguments of `course check`."""
    add_exercise_argument(parser)
    parser.add_argument(
        'file',
        nargs='?',
        type=Path,
        help="Your program (default: the exercise's file, here or in its folder)",
    )


def run(arguments: Namespace, output: Output) -> Outcome:
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
