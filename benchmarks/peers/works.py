"""The work that everybody is to do: its name, who does it, and the row of the table for a figure."""

from __future__ import annotations

from typing import NamedTuple

from benchmarks.line import Line
from benchmarks.lines import action_goals, service_spin, startup, topic_round_trip


class Work(NamedTuple):
    """A work: the argument of a peer's program, the line whose program does it on rclpy, and its size."""

    name: str
    line: Line
    operations: int


class Row(NamedTuple):
    """A row of the table: a figure of a work."""

    title: str
    work: str
    figure: str


WORKS = (
    Work('service', service_spin.LINE, 2000),
    Work('topic', topic_round_trip.LINE, 2000),
    Work('action', action_goals.LINE, 300),
    Work('start', startup.LINE, 5),
)
ROWS = (
    Row('service call, one after the other, µs', 'service', 'p50'),
    Row('the same, 99 of 100 take at most', 'service', 'p99'),
    Row('the same, CPU of both processes', 'service', 'cpu'),
    Row('topic there and back, µs', 'topic', 'p50'),
    Row('the same, 99 of 100 take at most', 'topic', 'p99'),
    Row('the same, CPU of both processes', 'topic', 'cpu'),
    Row('action, goal to result, µs', 'action', 'p50'),
    Row('start of a program to its first answer, ms', 'start', 'inside'),
    Row('of 5 starts got no answer within 10 s', 'start', 'lost'),
    Row('memory of that program, MB', 'start', 'memory'),
)
