"""Runs the programs of lines, subjects alternating, and collects what they print."""

from __future__ import annotations

import json
import os
import signal
import subprocess
from collections.abc import Callable, Iterable
from contextlib import suppress
from dataclasses import dataclass, field
from statistics import median
from typing import TypeAlias

from helpers.isolation import isolated_env

from benchmarks import ROOT, stage
from benchmarks.line import Figures, Line
from benchmarks.subjects import Subject

TOO_LONG_S = 90.0
Say: TypeAlias = Callable[[str], None]


class Failed(Exception):
    """A program ended without figures; the text says whose, and its last words."""


@dataclass
class Measured:
    """A line's figures: those of every round, by subject. Where one could not do it, why."""

    line: Line
    rounds: dict[str, list[Figures]] = field(default_factory=dict)
    failures: dict[str, str] = field(default_factory=dict)

    def figure(self, subject: str, name: str) -> float | None:
        """Return the median of the rounds."""
        values = self._values(subject, name)
        return median(values) if values else None

    def spread(self, subject: str, name: str) -> float:
        """Return how far the rounds lie apart, as a share of their median."""
        values = self._values(subject, name)
        middle = median(values) if values else 0.0
        return (max(values) - min(values)) / middle if middle else 0.0

    def ratio(self, subject: str, other: str, name: str) -> float | None:
        """Return one subject's figure as a multiple of another's: the median of each round's own ratio."""
        pairs = zip(self._values(subject, name), self._values(other, name), strict=False)
        ratios = [ours / theirs for ours, theirs in pairs if theirs]
        return median(ratios) if ratios else None

    def _values(self, subject: str, name: str) -> list[float]:
        return [figures[name] for figures in self.rounds.get(subject, []) if name in figures]


def run(subject: Subject, line: Line, *arguments: object) -> Figures | None:
    """Run a line's program once; None if the subject does no such work. Raises Failed."""
    command = subject.command(line, *arguments)
    if not command:
        return None
    env = {**isolated_env(subject.transport), **subject.env}
    if line.pinned:
        env[stage.PINNED] = _two_processors()
    env.pop('PYTHONDONTWRITEBYTECODE', None)  # to compile everything anew is half of a start
    process = subprocess.Popen(
        command, cwd=ROOT, env=env, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True,
        start_new_session=True,
    )  # fmt: skip
    try:
        output, errors = process.communicate(timeout=TOO_LONG_S)
    except subprocess.TimeoutExpired:
        raise Failed(f'{subject.name}: not done after {TOO_LONG_S:.0f} s') from None
    finally:
        _end_group(process)
    if process.returncode:
        last_words = ''.join(errors.strip().splitlines()[-1:])
        raise Failed(f'{subject.name}: {last_words or f"exit code {process.returncode}"}')
    figures: Figures = json.loads(output)
    return figures


def _two_processors() -> str:
    """Return two that may be used, as stage.PINNED has them. Raises Failed if there is only one."""
    usable = sorted(os.sched_getaffinity(0)) if hasattr(os, 'sched_getaffinity') else []
    if len(usable) < 2:
        raise Failed('no two processors to pin processes to')
    return f'{usable[0]},{usable[-1]}'


def _end_group(process: subprocess.Popen[str]) -> None:
    """End a program and its partners, whatever they are in the middle of."""
    with suppress(ProcessLookupError):
        os.killpg(process.pid, signal.SIGKILL)
    process.wait()


def measure(
    line: Line, subjects: Iterable[Subject], rounds: int, count: int, say: Say = lambda _: None
) -> Measured:
    """Measure a line in rounds, everybody in each; who fails once is not asked again."""
    measured = Measured(line)
    for number in range(rounds):
        for subject in subjects:
            if subject.name in measured.failures:
                continue
            say(f'{line.name}: round {number + 1}, {subject.name}')
            try:
                figures = run(subject, line, count)
            except Failed as error:
                measured.failures[subject.name] = str(error)
            else:
                if figures is not None:
                    measured.rounds.setdefault(subject.name, []).append(figures)
    return measured
