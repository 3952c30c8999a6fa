"""usage: python -m benchmarks.endurance [--scale 1] [--untimed] [calls] [nodes] [links] [publishers] [sizes]

100,000 calls, 10,000 nodes made and destroyed, 1000 links that come and go, 4000 publishers in each of two
processes, messages of 16 MB to 1 GB; each in processes of its own, on Zenoh. Prints what was found. Exit code
1 where something is left: memory, threads, descriptors, nodes, publishers; where time grows with the number;
where a message does not come. With --scale 0.01 a hundredth of it; --untimed for a busy machine.
"""

from __future__ import annotations

import argparse
import json
import os
import subprocess
import sys
import tempfile
from collections.abc import Iterator
from typing import NamedTuple

from benchmarks import stage
from benchmarks.line import Figures
from benchmarks.soak.__main__ import environment

SPARE_MIB = 3.0
"""The growth in memory that is allowed: allocators keep a little."""
SLOWER = 1.5
"""How many times as much processor time the last ones may take as the first."""


class Part(NamedTuple):
    """One thing that is done very often: how often, and how much memory each may leave, in KiB."""

    counts: tuple[int, ...]
    each_kib: float | None = None
    """None: what is made stays."""


PARTS = {
    'calls': Part((100_000,), 0.02),
    'nodes': Part((10_000,), 0.3),
    'links': Part((1020,), 1.0),
    'publishers': Part((4000,)),
    'sizes': Part((16_000_000, 64_000_000, 200_000_000, 1_000_000_000)),
}
PAIRS = (('first half CPU s', 'second half CPU s'), ('first ninth CPU s', 'last ninth CPU s'))


def problems(part: Part, count: int, figures: Figures, *, timed: bool) -> Iterator[str]:
    """Yield what is not as before."""
    for name, figure in figures.items():
        if name.endswith((' threads', ' files')) and figure > 0 and part.each_kib is not None:
            yield f'{figure:g} more {name}'
        elif name.endswith(' MiB') and part.each_kib is not None:
            grown = figure - figures[f'{name} before']
            if grown > SPARE_MIB + part.each_kib * count / 1024:
                yield f'{name}: {grown:.1f} more'
        elif name.endswith(' sees rightly') and figure != count:
            yield f'{name} {figure:g} of {count}'
        elif name == 'nodes left' and figure:
            yield f'{figure:g} nodes are left'
    for first, last in PAIRS:
        if timed and first in figures and figures[last] > SLOWER * figures[first]:
            yield f'the {last} went from {figures[first]:.1f} to {figures[last]:.1f}'


def run(name: str, count: int) -> Figures | str:
    """Run one part in a process of its own; return its figures, or why it has none."""
    command = [sys.executable, '-m', f'benchmarks.endurance.{name}', 'ask', str(count)]
    done = subprocess.run(command, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, check=False)
    if done.returncode:
        return '\n'.join(done.stdout.splitlines()[-20:]) or f'it ended with code {done.returncode}'
    figures: Figures = json.loads(done.stdout.splitlines()[-1])
    return figures


def main() -> None:
    """Take the arguments, and exit with the verdict."""
    parser = argparse.ArgumentParser(prog='python -m benchmarks.endurance', description=__doc__)
    parser.add_argument('--scale', type=float, default=1.0)
    parser.add_argument('--untimed', action='store_true')
    parser.add_argument('parts', nargs='*', metavar='PART', help=', '.join(PARTS))
    options = parser.parse_args()
    unknown = set(options.parts) - set(PARTS)
    if unknown:
        parser.error(f'no part is called {", ".join(unknown)}')
    found = 0
    with tempfile.TemporaryDirectory() as folder:
        os.environ |= environment('zenoh', folder)
        with stage.Partner('benchmarks.endurance.rendezvous'):
            os.environ['GOALWIRE_ROUTER'] = 'off'
            for name in options.parts or PARTS:
                for count in PARTS[name].counts:
                    found += judge(name, max(int(count * options.scale), 1), timed=not options.untimed)
    sys.exit(found > 0)


def judge(name: str, count: int, *, timed: bool) -> int:
    """Run one part, print what was found, and return how many problems there are."""
    figures = run(name, count)
    if isinstance(figures, str):
        print(f'{name} {count:,}\n    PROBLEM {figures}', flush=True)
        return 1
    print(f'{name} {count:,}: ' + ', '.join(f'{key} {value:.4g}' for key, value in figures.items()))
    wrong = list(problems(PARTS[name], count, figures, timed=timed))
    for each in wrong:
        print(f'    PROBLEM {each}')
    sys.stdout.flush()
    return len(wrong)


if __name__ == '__main__':
    main()
