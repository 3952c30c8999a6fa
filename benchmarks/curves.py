"""How goalwire scales: clients, size of messages, goals in flight, nodes. Plots, and their points as JSON."""

from __future__ import annotations

import json
import sys
from collections.abc import Callable, Iterable
from pathlib import Path
from typing import NamedTuple

from benchmarks import svg
from benchmarks.line import Line
from benchmarks.lines.scaling_clients import NODES, PROCESSES
from benchmarks.measuring import Failed, run
from benchmarks.subjects import DDS, RAW_DDS, RAW_NATIVE, ZENOH, Subject

ROUNDS = 2


class Curve(NamedTuple):
    """A plot: `figure` of the program `module` against values of `x`; the better of the rounds is shown.

    `operations` says how many are done at a value of x. The program's arguments: that number, x, and `more`.
    """

    name: str
    title: str
    x_title: str
    y_title: str
    module: str
    figure: str
    values: tuple[int, ...]
    operations: Callable[[int], int]
    subjects: tuple[Subject, ...] = (ZENOH, DDS)
    floor: str = ''
    more_is_better: bool = False
    more: tuple[str, ...] = ()


CURVES = (
    Curve(
        'clients', 'Calls a second, each client with one on its way', 'clients of one node', 'calls a second',
        'benchmarks.lines.scaling_clients', 'rate', (1, 4, 16, 64, 256), lambda x: 1000 + 100 * x,
        more_is_better=True,
    ),
    Curve(
        'clients-nodes', 'Calls a second, each client in its own node', 'nodes', 'calls a second',
        'benchmarks.lines.scaling_clients', 'rate', (1, 4, 16, 64), lambda x: 1000 + 100 * x,
        more_is_better=True, more=(NODES,),
    ),
    Curve(
        'clients-processes', 'Calls a second, each client in its own process', 'processes', 'calls a second',
        'benchmarks.lines.scaling_clients', 'rate', (1, 4, 16, 64), lambda x: 5000 + 200 * x,
        more_is_better=True, more=(PROCESSES,),
    ),
    Curve(
        'payload', 'From publish to the callback in another process', 'bytes of an Image', 'µs',
        'benchmarks.lines.scaling_payload', 'p50', tuple(4**power for power in range(3, 13)),
        lambda x: 300 if x < 200_000 else 60, (ZENOH, RAW_NATIVE, DDS, RAW_DDS), 'image',
    ),
    Curve(
        'goals', 'Goals a second, from sending to result', 'goals in flight', 'goals a second',
        'benchmarks.lines.scaling_goals', 'rate', (1, 3, 10, 30, 100, 300, 1000), lambda x: max(200, x),
        more_is_better=True,
    ),
    Curve(
        'nodes', 'Until all nodes in 8 processes have found each other', 'nodes, ten entities each', 's',
        'benchmarks.lines.many_nodes', 'found', (8, 24, 48, 96, 200), lambda x: x,
    ),
)  # fmt: skip


def points(curve: Curve, subject: Subject, scale: float) -> list[tuple[float, float]]:
    """Measure one curve of one subject."""
    line = Line(curve.title, curve.module, 0, (curve.figure,), (), floor=curve.floor)
    found = []
    for x in curve.values:
        count = max(int(curve.operations(x) * scale), 1) if curve.figure != 'found' else x
        arguments = (count,) if curve.figure == 'found' else (count, x, *curve.more)
        runs = [run(subject, line, *arguments) for _ in range(ROUNDS)]
        values = [figures[curve.figure] for figures in runs if figures]
        found.append((float(x), max(values) if curve.more_is_better else min(values)))
    return found


def main(folder: Path, scale: float, only: str = '', curves: Iterable[Curve] = CURVES) -> int:
    """Measure, and write a plot and its points for each curve."""
    folder.mkdir(parents=True, exist_ok=True)
    for curve in curves:
        if only not in curve.name:
            continue
        series = {}
        for subject in curve.subjects:
            try:
                series[subject.name] = points(curve, subject, scale)
            except Failed as error:
                print(f'{curve.name}: {error}', file=sys.stderr)
        plot = svg.curves(curve.title, curve.x_title, curve.y_title, series)
        (folder / f'{curve.name}.svg').write_text(plot, encoding='utf-8')
        (folder / f'{curve.name}.json').write_text(json.dumps(series), encoding='utf-8')
        print(curve.title, *(f'  {who}: {line}' for who, line in series.items()), sep='\n')
    return 0
