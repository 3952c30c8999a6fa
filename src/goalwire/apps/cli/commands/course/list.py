"""goalwire course list: the exercises."""

from __future__ import annotations

from argparse import ArgumentParser, Namespace
from typing import TYPE_CHECKING

from goalwire.apps.course.exercises import EXERCISES

if TYPE_CHECKING:
    from goalwire.apps.cli.framework.output import Output


def add_arguments(_parser: ArgumentParser) -> None:
    """Add no arguments: `course list` has none."""


def run(_arguments: Namespace, output: Output) -> None:
    """List them."""
    for exercise in EXERCISES:
        if output.json:
            output.data({'number': exercise.number, 'title': exercise.title, 'program': exercise.program})
        else:
            output.line(f'{exercise.number}  {exercise.title}: {exercise.program}')
    if not output.json:
        output.line('next: goalwire course start 1')
