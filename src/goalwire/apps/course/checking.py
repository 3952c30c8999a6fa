"""Checks a student's work: runs the steps of an exercise one after the other, up to the first that fails."""

from __future__ import annotations

import asyncio
import os
from collections.abc import AsyncIterator, Callable
from importlib import import_module
from pathlib import Path

from goalwire.apps.course.exercises import MATERIAL, Exercise
from goalwire.apps.course.student import Wrong
from goalwire.records import record


@record
class Report:
    """The findings of a check."""

    passed: list[str]
    """One sentence for each step that the program has passed."""
    problem: str = ''
    """The first mistake, as a sentence; empty if there is none."""
    advice: str = ''
    """The advice on the mistake: where to look, or what to do."""


def check(exercise: Exercise, file: Path, tell: Callable[[str], None] = lambda _step: None) -> Report:
    """Run the program in `file` and test it; `tell` is called with each step that the program has passed.

    The program runs as a process of its own, on a graph where it meets only this check. Every wait has a
    limit, so `check` returns whatever the program does. The interfaces are those of the exercise's material.
    """
    before = os.environ.get('GOALWIRE_INTERFACE_PATH')
    os.environ['GOALWIRE_INTERFACE_PATH'] = str(MATERIAL)
    try:
        return asyncio.run(_check(exercise, file.resolve(), tell))
    finally:
        if before is None:
            del os.environ['GOALWIRE_INTERFACE_PATH']
        else:
            os.environ['GOALWIRE_INTERFACE_PATH'] = before


async def _check(exercise: Exercise, file: Path, tell: Callable[[str], None]) -> Report:
    module = import_module(f'goalwire.apps.course.checks.{exercise.name}')
    steps: AsyncIterator[str] = module.steps(file)
    passed: list[str] = []
    try:
        async for step in steps:
            passed.append(step)
            tell(step)
    except Wrong as wrong:
        return Report(passed, str(wrong), wrong.advice)
    return Report(passed)
