"""Holds what was measured to the goals of the table."""

from __future__ import annotations

from collections.abc import Iterator
from typing import NamedTuple

from benchmarks.line import Goal, Of
from benchmarks.measuring import Measured
from benchmarks.subjects import DDS, PEER, RAW, ZENOH


class Verdict(NamedTuple):
    """One goal on one wire: the figure, its multiple of what the goal names, and whether that is enough.

    `peer` is the multiple of the real rclpy's figure beside, where the goal is one of the reference; `met` is
    None where nothing could be measured.
    """

    goal: Goal
    subject: str
    limit: float
    figure: float | None
    multiple: float | None
    peer: float | None

    @property
    def met(self) -> bool | None:
        return self._within(self.multiple)

    @property
    def met_beside(self) -> bool | None:
        return self._within(self.peer)

    def _within(self, value: float | None) -> bool | None:
        if value is None:
            return None
        return value >= self.limit if self.goal.at_least else value <= self.limit


def judge(measured: Measured) -> Iterator[Verdict]:
    """Yield a verdict for each goal on each wire."""
    line = measured.line
    for goal in line.goals:
        for subject, limit in ((ZENOH.name, goal.zenoh), (DDS.name, goal.dds)):
            figure = measured.figure(subject, goal.figure)
            beside = None
            if goal.of is Of.REFERENCE:
                multiple = None if figure is None else figure / line.reference[goal.figure]
                beside = measured.ratio(subject, PEER, goal.figure)
            elif goal.of is Of.RAW:
                multiple = measured.ratio(subject, RAW[subject], goal.figure)
            else:
                multiple = figure
            yield Verdict(goal, subject, limit, figure, multiple, beside)
