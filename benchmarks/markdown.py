"""The report as Markdown: the goals, met or not, and everything that was measured."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping

from benchmarks.line import FIGURES, Of
from benchmarks.measuring import Measured
from benchmarks.subjects import (
    DDS,
    DDS_LIBRARY,
    ECLIPSE,
    PEER,
    PEER_EVENTS,
    RAW_DDS,
    RAW_ECLIPSE,
    RAW_NATIVE,
    RAW_NATIVE_NO_LOOK,
    REFERENCE,
    TCP,
    ZENOH,
    ZENOH_EVENTS,
    ZENOH_MULTI,
    ZENOH_NO_LOOK,
)
from benchmarks.verdicts import Verdict, judge

OF = {
    Of.REFERENCE: ' of the reference',
    Of.RAW: ' of raw',
    Of.TCP: ' of Python on TCP',
    Of.ECLIPSE: " of eclipse-zenoh's",
    Of.ONE: '',
}
NOTHING = '\N{EN DASH}'
GOALWIRE = {
    ZENOH.name: 'Zenoh',
    ZENOH_NO_LOOK.name: 'no look',
    ECLIPSE.name: "eclipse-zenoh's session",
    DDS.name: 'DDS',
    DDS_LIBRARY.name: "libddsc's session",
    PEER: 'rclpy beside',
    REFERENCE: 'reference',
}
"""The columns of the table of goalwire and the real rclpy."""
EXECUTORS = {
    ZENOH.name: 'Zenoh',
    ZENOH_EVENTS.name: 'its EventsExecutor',
    ZENOH_MULTI.name: 'its MultiThreadedExecutor',
    PEER: 'rclpy beside',
    PEER_EVENTS: "rclpy's EventsExecutor",
}
"""The columns of the table of executors."""
FLOORS = {
    ZENOH.name: 'Zenoh',
    RAW_NATIVE.name: 'its session alone',
    TCP.name: 'Python on TCP',
    ZENOH_NO_LOOK.name: 'no look',
    RAW_NATIVE_NO_LOOK.name: 'its session, no look',
    ECLIPSE.name: "eclipse-zenoh's session",
    RAW_ECLIPSE.name: 'eclipse-zenoh alone',
    DDS.name: 'DDS',
    DDS_LIBRARY.name: "libddsc's session",
    RAW_DDS.name: 'libddsc alone',
}
"""The columns of the table of raw wires, each behind what stands on it."""
MARK = {True: 'yes', False: '**no**', None: NOTHING}


def report(facts: Mapping[str, str], results: Iterable[Measured], no_peer: str) -> str:
    """Return the whole report."""
    measured = list(results)
    parts = ['# Benchmarks', '', *(f'- {name}: {text}' for name, text in facts.items())]
    if no_peer:
        parts += ['', f'The real rclpy was not measured: {no_peer}.']
    parts += ['', '## Goals', '', *goals(measured), '', '## Figures', '', *figures(measured, GOALWIRE)]
    spun = [result for result in measured if result.line.spins]
    parts += ['', '## Executors', '', *figures(spun, EXECUTORS)] if spun else []
    floors = [result for result in measured if result.line.floor]
    parts += ['', '## Beside the raw wires', '', *figures(floors, FLOORS)] if floors else []
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
            cells = [result.line.name, GOALWIRE[verdict.subject], *_cells(verdict)]
            yield f'| {" | ".join(cells)} |'


def _cells(verdict: Verdict) -> list[str]:
    goal = verdict.goal
    sign = '≥' if goal.at_least else '≤'
    return [
        goal.figure,
        shown(goal.figure, verdict.figure),
        f'{sign} {verdict.limit:g}{OF[goal.of]}',
        NOTHING if verdict.multiple is None else f'{verdict.multiple:.3g}',
        MARK[verdict.met],
        NOTHING if verdict.peer is None else f'{verdict.peer:.3g}',
        MARK[verdict.met_beside],
    ]


def figures(results: Iterable[Measured], columns: Mapping[str, str]) -> Iterator[str]:
    """Yield a table of medians: a row for each figure, a column for each subject, named by `columns`.

    The first figure of a line says in brackets how far its rounds lie apart.
    """
    yield f'| work | {" | ".join(columns.values())} |'
    yield f'|---|{"---|" * len(columns)}'
    for result in results:
        if not result.rounds.keys() & columns.keys():
            continue
        for figure in result.line.figures:
            unit = FIGURES[figure][0]
            cells = [_median(result, who, figure) for who in columns]
            yield f'| {result.line.name}: {figure}{f", {unit}" if unit else ""} | {" | ".join(cells)} |'


def _median(result: Measured, who: str, figure: str) -> str:
    value = result.line.reference.get(figure) if who == REFERENCE else result.figure(who, figure)
    if value is None:
        return NOTHING
    differ = f' ({result.spread(who, figure):.0%})' if figure == result.line.figures[0] else ''
    return number(value) + (differ if who != REFERENCE else '')


def shown(figure: str, value: float | None) -> str:
    """Return a figure with its unit."""
    if value is None:
        return NOTHING
    return f'{number(value)} {FIGURES[figure][0]}'.strip()


def number(value: float) -> str:
    """Return a figure, three digits of it at least."""
    return f'{value:,.0f}' if abs(value) >= 100 else f'{value:.3g}'
