"""The start of a program up to its first answer, as a process of its own: the same for everybody."""

from __future__ import annotations

import os
import subprocess
import sys
from statistics import median
from time import perf_counter
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from benchmarks.line import Figures

PATIENCE_S = 10.0
"""A start without an answer for so long counts as lost."""


def tell(begun: float) -> None:
    """Print the milliseconds since `begun`, a reading of perf_counter, and the resident memory in MB."""
    inside = perf_counter() - begun
    with open('/proc/self/statm', encoding='ascii') as file:  # noqa: PTH123 - pathlib would be in the figure
        resident = int(file.read().split()[1]) * os.sysconf('SC_PAGE_SIZE')
    print(inside * 1e3, resident / 1e6, flush=True)


def measure(module: str, count: int, *arguments: object) -> Figures:
    """Run a module's `first` several times, once more before that, and return the medians.

    `lost` is how many of these starts got no answer.
    """
    command = [sys.executable, '-m', module, 'first', *map(str, arguments)]
    runs, lost = [], 0
    for number in range(count + 1):
        try:
            done = subprocess.run(command, check=True, stdout=subprocess.PIPE, text=True, timeout=PATIENCE_S)
        except (subprocess.TimeoutExpired, subprocess.CalledProcessError):
            lost += number > 0
            continue
        if number:
            runs.append([float(text) for text in done.stdout.split()[-2:]])
    if not runs:
        sys.exit(f'none of {count} starts got an answer')
    inside, memory = zip(*runs, strict=True)
    return {'inside': median(inside), 'memory': median(memory), 'lost': lost}
