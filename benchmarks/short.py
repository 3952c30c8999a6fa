"""For CI: has goalwire become slower than it was, measured against the raw wire and plain Python beside it?

Times say little on a machine that others use, so only ratios count, each of the best rounds of both; what
they are held to lies in expected.json, with a wide band around it: this finds a doubling, not five percent.
Both processes of a program share one processor: which of two the system wakes for a message is luck, and
a wake-up across them takes longer than the message.
`python -m benchmarks.short accept` writes what it measures, the highest of several runs, into that file.
"""

from __future__ import annotations

import json
import os
import sys
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import NamedTuple

from benchmarks import stage
from benchmarks.line import Figures, Line
from benchmarks.lines import asyncio_calls, service_spin, startup, topic_round_trip, topic_throughput
from benchmarks.measuring import run
from benchmarks.subjects import DDS, NO_LOOK, RAW_DDS, RAW_NATIVE, TCP, ZENOH, Subject, has_dds

EXPECTED = Path(__file__).with_name('expected.json')
BAND = 1.6
"""How many times the expected ratio is still taken for noise."""
ROUNDS = 2
MORE_RUNS = 2
"""How often what seems slower is measured again: other programs are done by then, a doubling stays."""
ACCEPTED_RUNS = 6
"""The number of runs whose highest figure becomes the expected one."""
MEMORY = Subject('goalwire in one process', 'goalwire_memory', lambda line: [line.module, 'ask'])
LOCAL = Line('in one process', 'benchmarks.in_process', 3, (), ())
START = Line('parts of a start', 'benchmarks.start_parts', 8, (), ())


def on_one_processor(subject: Subject) -> Subject:
    """Return the subject with both its processes on one processor, where a look before a sleep cannot pay."""
    first = min(os.sched_getaffinity(0))
    return subject._replace(env={**subject.env, **NO_LOOK, stage.PINNED: f'{first},{first}'})


OURS, RAW, PLAIN_TCP = map(on_one_processor, (ZENOH, RAW_NATIVE, TCP))
OURS_ON_DDS, LIBDDSC = map(on_one_processor, (DDS, RAW_DDS))


class Pair(NamedTuple):
    """A figure of goalwire's as a multiple of somebody else's, in as many operations a round."""

    name: str
    line: Line
    figure: str
    operations: int
    ours: Subject
    base: Subject


PAIRS = (
    Pair("the Zenoh session's query, time, of TCP", service_spin.LINE, 'p50', 500, RAW, PLAIN_TCP),
    Pair("the Zenoh session's put, time, of TCP", topic_round_trip.LINE, 'p50', 500, RAW, PLAIN_TCP),
    Pair('service call on Zenoh, time, of raw', service_spin.LINE, 'p50', 500, OURS, RAW),
    Pair('service call on Zenoh, CPU, of raw', service_spin.LINE, 'cpu', 500, OURS, RAW),
    Pair('service call on DDS, time, of raw', service_spin.LINE, 'p50', 500, OURS_ON_DDS, LIBDDSC),
    Pair('service call on DDS, CPU, of raw', service_spin.LINE, 'cpu', 500, OURS_ON_DDS, LIBDDSC),
    Pair('topic round trip on Zenoh, time, of raw', topic_round_trip.LINE, 'p50', 500, OURS, RAW),
    Pair('topic round trip on DDS, time, of raw', topic_round_trip.LINE, 'p50', 500, OURS_ON_DDS, LIBDDSC),
    Pair('asyncio call on Zenoh, time, of raw', asyncio_calls.LINE, 'p50', 500, OURS, RAW),
    Pair('message received on Zenoh, CPU, of raw', topic_throughput.LINE, 'cpu_here', 20_000, OURS, RAW),
)
PARTS = {'pth': 'the line of goalwire.pth', 'import': 'import rclpy', 'node': 'init and a node'}
IN_PROCESS = ('call', 'topic', 'encode', 'decode', 'new')


def best(pairs: Iterable[Pair]) -> dict[tuple[str, str], Figures]:
    """Return each subject's lowest figures of each line, over the rounds."""
    found: dict[tuple[str, str], Figures] = {}
    wanted = {(pair.line.module, who.name): (pair, who) for pair in pairs for who in (pair.ours, pair.base)}
    for _ in range(ROUNDS):
        for key, (pair, who) in wanted.items():
            figures = run(who, pair.line, pair.operations) or {}
            known = found.setdefault(key, figures)
            found[key] = {name: min(value, known[name]) for name, value in figures.items()}
    return found


def ratios() -> dict[str, float]:
    """Measure every ratio."""
    pairs = [pair for pair in PAIRS if pair.ours is not OURS_ON_DDS or has_dds()]
    figures = best(pairs)
    measured = {
        pair.name: figures[pair.line.module, pair.ours.name][pair.figure]
        / figures[pair.line.module, pair.base.name][pair.figure]
        for pair in pairs
    }
    local = run(MEMORY, LOCAL, LOCAL.operations) or {}
    measured |= {
        f'{name} in one process, of plain Python': local[name] / local['yardstick'] for name in IN_PROCESS
    }
    parts = run(MEMORY, START, START.operations) or {}
    measured |= {
        f'{name}, CPU, of plain Python': parts[part] / local['yardstick'] for part, name in PARTS.items()
    }
    begun = [run(ZENOH, startup.LINE, 3) or {} for _ in range(ROUNDS)]
    cpu = min(run_['cpu_here'] for run_ in begun)
    measured['first call on Zenoh, CPU, of plain Python'] = cpu / local['yardstick'] / 1000
    return measured


def slowed(measured: Mapping[str, float], expected: Mapping[str, float]) -> list[str]:
    """Return the names of what has become slower than noise explains."""
    return [name for name, ratio in measured.items() if ratio > expected[name] * BAND]


def main(*, accept: bool = False) -> int:
    """Measure, compare, and return the exit code."""
    runs = [ratios() for _ in range(ACCEPTED_RUNS if accept else 1)]
    measured = {name: max(each[name] for each in runs) for name in runs[0]}
    if accept:
        rounded = {name: float(f'{ratio:.3g}') for name, ratio in measured.items()}
        EXPECTED.write_text(json.dumps(rounded, indent=1) + '\n', encoding='utf-8')
    expected: dict[str, float] = json.loads(EXPECTED.read_text(encoding='utf-8'))
    for _ in range(MORE_RUNS):
        if slowed(measured, expected):
            again = ratios()
            measured = {name: min(ratio, again[name]) for name, ratio in measured.items()}
    slower = slowed(measured, expected)
    for name, ratio in measured.items():
        mark = '  SLOWER' if name in slower else ''
        print(f'{name:55} {ratio:7.2f}   expected {expected[name]:.2f}{mark}')
    if slower:
        print(f'\n{len(slower)} ratios are more than {BAND} times what they were ({EXPECTED.name}).')
    return int(bool(slower))


if __name__ == '__main__':
    sys.exit(main(accept='accept' in sys.argv))
