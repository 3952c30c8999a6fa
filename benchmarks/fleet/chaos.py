"""Kills and partitions the routers of a fleet at random, while goals and calls go to all robots."""

from __future__ import annotations

import subprocess
import time
from collections import Counter
from random import Random

from benchmarks.fleet.books import Books
from benchmarks.fleet.layout import Layout, cpu_s, expect, memory_mb
from benchmarks.fleet.programs import DISPATCHER

PAUSE_S = (5.0, 25.0)
"""From the end of a kill, or the beginning of a partition, to the next fault."""
DOWN_S = (1.0, 10.0)
PARTITION_S = (5.0, 60.0)
KILLED, ALL, ONE = 'killed', 'all links partitioned', 'a link partitioned'
SHOWN = 20
"""How many problems are printed."""


def go_through_chaos(layout: Layout, programs: list[subprocess.Popen[str]], seconds: float) -> int:
    """Send goals and calls for some time under faults, print the books, return the number of problems."""
    seed = time.time_ns()
    print(f'  seed {seed}', flush=True)
    watched = {'a program of robots': programs[0]}
    arguments = str(layout.folder), str(layout.robots), str(seconds)
    dispatcher = layout.operate(DISPATCHER, *arguments, begins='sends')
    watched['the dispatcher'] = dispatcher
    before = {name: (memory_mb(each), cpu_s(each)) for name, each in watched.items()}
    began = time.monotonic()
    faults = _break_things(layout, Random(seed), began + seconds)
    after = {name: (memory_mb(each), cpu_s(each)) for name, each in watched.items()}
    expect(dispatcher, 'has ended')
    print(f'  faults: {dict(faults)}')
    for name, (memory, cpu) in after.items():
        first, spent = before[name]
        share = 100 * (cpu - spent) / seconds
        print(f'  {name}: {first:.0f} MB at first, {memory:.0f} MB at last, {share:.1f} % of a core')
    books = Books(layout.folder)
    print(books.table())
    print(f'{len(books.problems)} problems', *books.problems[:SHOWN], sep='\n  ', flush=True)
    return len(books.problems)


def _break_things(layout: Layout, random: Random, until: float) -> Counter[str]:
    """Kill a router or partition its links, again and again. All partitions are over by `until`."""
    began = time.monotonic()
    faults: Counter[str] = Counter()
    while until - time.monotonic() > PAUSE_S[1] + PARTITION_S[1]:
        time.sleep(random.uniform(*PAUSE_S))
        name = random.choice(list(layout.running))
        kind = random.choice((KILLED, ALL, ONE))
        lasts = random.uniform(*(DOWN_S if kind == KILLED else PARTITION_S))
        print(f'  {time.monotonic() - began:6.0f} s: {name} {kind} for {lasts:.1f} s', flush=True)
        faults[f'{name} {kind}'] += 1
        if kind == KILLED:
            layout.kill_router(name)
            time.sleep(lasts)
            layout.begin_router(name)
        else:
            layout.partition(name, lasts, everything=kind == ALL)
    time.sleep(max(0.0, until - time.monotonic()))
    return faults
