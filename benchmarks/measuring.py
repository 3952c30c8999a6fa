"""Runs the programs of lines, subjects alternating, and collects what they print."""

from __future__ import annotations

import json
import subprocess
from collections.abc import Callable, Iterable
from dataclasses import dataclass, field
from statistics import median
from typing import TypeAlias

from helpers.isolation import isolated_env

from benchmarks import ROOT
from benchmarks.line import Figures, Line
from benchmarks.subjects import Subject

TOO_LONG_S = 60.0
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
    """Run a line's program once; None where the subject does no such work. Raises Failed."""
    command = subject.command(line, *arguments)
    if not command:
        return None
    env = {**isolated_env(subject.transport), **subject.env}
    env.pop(
        'PYTHONDONTWRITEBYTECODE', None
    )  # to compile everything anew is half of a start
    try:
        done = subprocess.run(
            command, cwd=ROOT, env=env, capture_output=True, text=True, timeout=TOO_LONG_S, check=False
        )
    except subprocess.TimeoutExpired:
        raise Failed(f'{subject.name}: not done after {TOO_LONG_S:.0f} s') from None
    if done.returncode:
        last_words = ''.join(done.stderr.strip().splitlines()[-1:])
        raise Failed(f'{subject.name}: {last_words or f"exit code {done.returncode}"}')
    figures: Figures = json.loads(done.stdout)
    return figures


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
