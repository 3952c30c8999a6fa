"""Resident memory of a program that has made one call."""

from __future__ import annotations

from benchmarks import stage
from benchmarks.line import Goal, Line, Of
from benchmarks.lines.service_spin import answer
from benchmarks.lines.startup import ask

LINE = Line(
    'resident memory of that client',
    __name__,
    1,
    ('memory',),
    (Goal('memory', Of.REFERENCE, 0.5, 0.6),),
    {'memory': 53},
    looks=False,
    spins=False,
)

if __name__ == '__main__':
    stage.run(ask, answer)
