"""How long a program takes to its first answer: import, node, discovery, one call."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path
from statistics import median
from time import monotonic

from benchmarks import spinning, stage
from benchmarks.line import Figures, Goal, Line, Of
from benchmarks.lines.service_name import SERVICE
from benchmarks.lines.service_spin import answer

CLIENT = Path(__file__).with_name('first_call.py')

LINE = Line(
    'import, node, discovery, first call',
    __name__,
    5,
    ('inside', 'wall', 'cpu_here'),
    (Goal('inside', Of.REFERENCE, 0.25, 0.3),),
    {'inside': 498},
    looks=False,
    spins=False,
)


def first_call() -> Figures:
    """Run the client once, and return what it says of itself."""
    done = subprocess.run(
        [sys.executable, '-P', str(CLIENT), str(monotonic()), SERVICE],
        check=True, stdout=subprocess.PIPE, text=True, timeout=2 * spinning.PATIENCE_S,
    )  # fmt: skip
    inside, wall, cpu, memory = map(float, done.stdout.split())
    return {'inside': inside, 'wall': wall, 'cpu_here': cpu * 1e3, 'memory': memory}


def ask(count: int) -> Figures:
    with stage.Partner('benchmarks.lines.service_spin'):
        first_call()
        runs = [first_call() for _ in range(count)]
        return {name: median(run[name] for run in runs) for name in runs[0]}


if __name__ == '__main__':
    stage.run(ask, answer)
