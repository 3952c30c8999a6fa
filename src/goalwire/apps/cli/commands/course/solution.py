"""goalwire course solution: one way to do an exercise."""

from __future__ import annotations

from argparse import ArgumentParser, Namespace
from typing import TYPE_CHECKING

from goalwire.apps.cli.commands.course.choosing import add_exercise_argument, find_exercise

if TYPE_CHECKING:
    from goalwire.apps.cli.framework.output import Output


def add_arguments(parser: ArgumentParser) -> None:
    """Add the arguments of `course solution`."""
    add_exercise_argument(parser)


def run(arguments: Namespace, output: Output) -> None:
    """Print only the program, so that the output can be redirected into a file."""
    output.block(find_exercise(arguments).read('solution.py'), end='')
