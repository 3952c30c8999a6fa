"""The argument that every verb of `course` but `list` takes."""

from __future__ import annotations

from argparse import ArgumentParser, Namespace

from goalwire.apps.cli.framework.outcome import CommandError, Outcome
from goalwire.apps.course.exercises import EXERCISES, Exercise


def add_exercise_argument(parser: ArgumentParser) -> None:
    """Add the argument for the number of an exercise."""
    parser.add_argument('exercise', help=f'Its number, 1 to {len(EXERCISES)}')


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
