"""The report as Markdown: the goals, met or not, and everything that was measured."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping

from benchmarks.line import FIGURES, Of
from benchmarks.measuring import Measured
from benchmarks.subjects import PEER
from benchmarks.verdicts import Verdict, judge

NOTHING = '\N{EN DASH}'
MARK = {True: 'yes', False: '**no**', None: NOTHING}


def report(facts: Mapping[str, str], results: Iterable[Measured], no_peer: str) -> str:
    """Return the whole report."""
    measured = list(results)
    parts = ['# Benchmarks', '', *(f'- {name}: {text}' for name, text in facts.items())]
    if no_peer:
        parts += ['', f'The real rclpy was not measured: {no_peer}.']
    parts += ['', '## Goals', '', *goals(measured), '', '## Figures', '', *figures(measured)]
    failures = [f'{result.line.name}: {text}' for result in measured for text in result.failures.values()]
    if failures:
        parts += ['', '## Not measured', '', *(f'- {text}' for text in failures)]
    return '\n'.join(parts) + '\n'


def goals(results: Iterable[Measured]) -> Iterator[str]:
    """Yield the table of goals: each figure as a multiple of what its goal names."""
    yield '| work | wire | figure | measured | goal | reached | met | to rclpy beside | met |'
    yield '|---|---|---|---|---|---|---|---|---|'
    for result in results:
        for verdict in judge(result):
            cells = [result.line.name, verdict.subject.removeprefix('goalwire on '), *_cells(verdict)]
            yield f'| {" | ".join(cells)} |'


def _cells(verdict: Verdict) -> list[str]:
    goal = verdict.goal
    sign = '≥' if goal.at_least else '≤'
    of = {Of.REFERENCE: ' of the reference', Of.RAW: ' of raw', Of.ONE: ''}[goal.of]
    return [
        goal.figure,
        shown(goal.figure, verdict.figure),
        f'{sign} {verdict.limit:g}{of}',
        NOTHING if verdict.multiple is None else f'{verdict.multiple:.3g}',
        MARK[verdict.met],
        NOTHING if verdict.peer is None else f'{verdict.peer:.3g}',
        MARK[verdict.met_beside],
    ]


def figures(results: Iterable[Measured]) -> Iterator[str]:
    """Yield the table of medians, with how far the rounds lie apart."""
    yield '| work | who | figures | rounds differ by |'
    yield '|---|---|---|---|'
    for result in results:
        line = result.line
        for name in result.rounds:
            values = ', '.join(
                f'{figure} {shown(figure, value)}'
                for figure in line.figures
                if (value := result.figure(name, figure)) is not None
            )
            yield f'| {line.name} | {name} | {values} | {result.spread(name, line.figures[0]):.0%} |'
        if line.reference:
            values = ', '.join(f'{figure} {shown(figure, value)}' for figure, value in line.reference.items())
            yield f'| {line.name} | reference: {PEER.replace("Fast", "Cyclone")} | {values} | |'


def shown(figure: str, value: float | None) -> str:
    """Return a figure with its unit."""
    if value is None:
        return NOTHING
    unit = FIGURES[figure][0]
    text = f'{value:,.0f}' if abs(value) >= 100 else f'{value:.3g}'
    return f'{text} {unit}'.strip()
