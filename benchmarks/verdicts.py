"""Holds what was measured to the goals of the table."""

from __future__ import annotations

from collections.abc import Iterator
from typing import NamedTuple

from benchmarks.line import Goal, Of
from benchmarks.measuring import Measured
from benchmarks.subjects import DDS, ECLIPSE, PEERS, RAW, TCP, ZENOH, ZENOH_NO_LOOK


class Verdict(NamedTuple):
    """One goal on one wire: the figure, its multiple of what the goal names, and whether that is enough.

    `peer` is the multiple of the real rclpy's figure beside, with the better one of its executors, where the
    goal is one of the reference; `met` is None if nothing could be measured.
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
    """Yield a verdict for each goal on each wire that has one."""
    for goal in measured.line.goals:
        limits = ((ZENOH.name, goal.zenoh), (ZENOH_NO_LOOK.name, goal.no_look), (DDS.name, goal.dds))
        for subject, limit in limits:
            if limit is None:
                continue
            figure = measured.figure(subject, goal.figure)
            beside = _beside(measured, subject, goal) if goal.of is Of.REFERENCE else None
            yield Verdict(goal, subject, limit, figure, _multiple(measured, subject, goal), beside)


def _beside(measured: Measured, subject: str, goal: Goal) -> float | None:
    """Return a subject's figure as a multiple of the real rclpy's, with the executor that does it better."""
    ratios = [measured.ratio(subject, peer, goal.figure) for peer in PEERS]
    known = [ratio for ratio in ratios if ratio is not None]
    return (min if goal.at_least else max)(known) if known else None


def _multiple(measured: Measured, subject: str, goal: Goal) -> float | None:
    """Return a subject's figure as a multiple of what the goal names; None where either is missing."""
    figure = measured.figure(subject, goal.figure)
    if figure is None or goal.of is Of.ONE:
        return figure
    if goal.of is Of.REFERENCE:
        return figure / measured.line.reference[goal.figure]
    other = {Of.RAW: RAW[subject], Of.TCP: TCP.name, Of.ECLIPSE: ECLIPSE.name}[goal.of]
    return measured.ratio(subject, other, goal.figure)
