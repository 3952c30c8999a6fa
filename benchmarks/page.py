"""Puts the figures of a run into docs/reference/performance.md, and draws the picture at its head anew.

usage: python -m benchmarks.page [REPORT]     REPORT is build/bench/report.json, which `make bench` writes

The page has comments where the figures go: `<!-- bench: head -->` and `<!-- bench: tables -->`, each up to
`<!-- bench: end -->`. All else on it is written by hand.
"""

from __future__ import annotations

import json
import sys
from collections.abc import Iterable, Iterator, Mapping
from pathlib import Path
from typing import NamedTuple

from benchmarks import ROOT
from benchmarks.line import Line
from benchmarks.lines import (
    action_feedback,
    action_first_goal,
    action_goals,
    asyncio_calls,
    image,
    many_nodes,
    memory,
    service_blocking,
    service_in_flight,
    service_spin,
    startup,
    timer,
    topic_round_trip,
    topic_throughput,
)
from benchmarks.markdown import EXECUTORS, FLOORS, GOALWIRE, NOTHING, OF, number
from benchmarks.measuring import Measured
from benchmarks.subjects import DDS, PEER, REFERENCE, ZENOH
from benchmarks.verdicts import judge

PAGE = ROOT / 'docs' / 'reference' / 'performance.md'
REPORT = ROOT / 'build' / 'bench' / 'report.json'


class Row(NamedTuple):
    """One row of the page's table: figures of a line, under a name that tells their unit."""

    name: str
    line: Line
    figures: tuple[str, ...]


ROWS = (
    Row('service call, `call_async` + `spin_until_future_complete`', service_spin.LINE, ('p50',)),
    Row('the same, CPU of both processes', service_spin.LINE, ('cpu',)),
    Row('the same call, processes pinned apart', service_spin.PINNED, ('p50',)),
    Row('service call, blocking `call`, a thread spins', service_blocking.LINE, ('p50',)),
    Row('32 calls in flight, calls/s; lost', service_in_flight.LINE, ('rate', 'lost')),
    Row('topic there and back, callbacks both sides', topic_round_trip.LINE, ('p50',)),
    Row('there and back, CPU of both processes', topic_round_trip.LINE, ('cpu',)),
    Row('the same round trip, processes pinned apart', topic_round_trip.PINNED, ('p50',)),
    Row('PoseStamped to a callback, messages/s', topic_throughput.LINE, ('rate',)),
    Row('the same, CPU a message', topic_throughput.LINE, ('cpu_here',)),
    Row('action, goal to result, after 200 goals', action_goals.LINE, ('p50',)),
    Row('the same, the last hundred to the first', action_goals.LINE, ('growth',)),
    Row('feedback, messages/s; share that came', action_feedback.LINE, ('rate', 'arrived')),
    Row('first goal of a client to its tenth', action_first_goal.LINE, ('first_to_tenth',)),
    Row('1 kHz timer, CPU a tick', timer.LINE, ('cpu',)),
    Row('import, node, discovery, first call, ms', startup.LINE, ('inside',)),
    Row('memory of that client, MB', memory.LINE, ('memory',)),
    Row('asyncio client, one call after the other', asyncio_calls.LINE, ('p50',)),
    Row('1 MB image to a callback', image.LINE, ('p50',)),
    Row('200 nodes, 2000 entities, 8 processes: found, s', many_nodes.LINE, ('found',)),
    Row('the same at rest, CPU %', many_nodes.LINE, ('idle',)),
)


class Run(NamedTuple):
    """The results of `make bench`: facts about the run, and lines by their names."""

    facts: Mapping[str, str]
    lines: Mapping[str, Measured]

    def shown(self, row: Row, who: str) -> str:
        """Return a cell: figures in bold if they meet every goal that they have."""
        measured = self.lines.get(row.line.name)
        if measured is None:
            return NOTHING
        values = [(figure, _value(measured, who, figure)) for figure in row.figures]
        text = '; '.join(_text(figure, value) for figure, value in values if value is not None)
        verdicts = [
            each for each in judge(measured) if each.subject == who and each.goal.figure in row.figures
        ]
        is_met = verdicts and all(each.met for each in verdicts)
        return (f'**{text}**' if is_met else text) or NOTHING

    def figure(self, line: Line, who: str) -> str:
        """Return a line's first figure. Raises SystemExit if it is missing."""
        value = self.lines[line.name].figure(who, line.figures[0]) if line.name in self.lines else None
        if value is None:
            sys.exit(
                f'{who} has no figure for "{line.name}" in this report; the page needs a whole `make bench`'
            )
        return number(value)


def _value(measured: Measured, who: str, figure: str) -> float | None:
    return measured.line.reference.get(figure) if who == REFERENCE else measured.figure(who, figure)


def _text(figure: str, value: float) -> str:
    if figure == 'arrived':
        return 'all' if value == 1 else f'{value:.0%}'
    return number(value)


def read(report: Path) -> Run:
    """Read what a run has written."""
    raw = json.loads(report.read_text(encoding='utf-8'))
    known = {row.line.name: row.line for row in ROWS}
    lines = {
        name: Measured(known[name], found['rounds'], found['failures'])
        for name, found in raw['lines'].items()
        if name in known
    }
    return Run(raw['facts'], lines)


def head(run: Run) -> Iterator[str]:
    """Yield what the page begins with."""
    on_zenoh, on_dds, peer = (
        [run.figure(line, who) for line in (service_spin.LINE, topic_throughput.LINE, startup.LINE)]
        for who in (ZENOH.name, DDS.name, PEER)
    )
    on_cyclone = number(service_spin.LINE.reference['p50'])
    yield (
        f'- A service call takes **{on_zenoh[0]}** µs on Zenoh and **{on_dds[0]}** µs on DDS. The real rclpy '
        f'takes {peer[0]} µs beside it on Fast DDS, and {on_cyclone} µs on Cyclone DDS.'
    )
    yield (
        f'- A subscription takes **{on_zenoh[1]}** messages a second on Zenoh and **{on_dds[1]}** on '
        f'DDS. The real rclpy takes {peer[1]}.'
    )
    yield (
        f'- A program has its first answer **{on_zenoh[2]}** ms after its start on Zenoh and **{on_dds[2]}** '
        f'ms on DDS. The real rclpy needs {peer[2]} ms.'
    )


def tables(run: Run) -> Iterator[str]:
    """Yield the tables, and what is not met."""
    facts = run.facts
    yield (
        f'Medians of the rounds of one `make bench` ({facts["taken"]}; load {facts["load before"]}) '
        f'on {facts["machine"]}; Python {facts["Python"]}; {facts["Zenoh"]}; {facts["DDS"]}. Beside it ran '
        f'the real rclpy {facts["rclpy"]}. The reference is the real rclpy of Jazzy on Cyclone DDS, measured '
        f'earlier on a quiet 2-core machine. µs, unless a row says otherwise; bold meets its goals.'
    )
    yield ''
    yield from _table('work', ROWS, run, GOALWIRE)
    yield ''
    yield 'The same with other executors, of goalwire and of the real rclpy:'
    yield ''
    yield from _table('by executor', [row for row in ROWS if row.line.spins], run, EXECUTORS)
    yield ''
    yield 'The same beside the raw wires, each behind what stands on it:'
    yield ''
    rows = [row for row in ROWS if row.line.floor]
    yield from _table('beside the raw wires', rows, run, FLOORS)
    missed = list(not_met(run))
    yield ''
    yield 'Goals that are not met:' if missed else 'All goals are met.'
    if missed:
        yield ''
        yield from missed


def _table(first: str, rows: Iterable[Row], run: Run, columns: Mapping[str, str]) -> Iterator[str]:
    yield f'| {first} | {" | ".join(columns.values())} |'
    yield f'|---|{"---|" * len(columns)}'
    for row in rows:
        yield f'| {row.name} | {" | ".join(run.shown(row, who) for who in columns)} |'


def not_met(run: Run) -> Iterator[str]:
    """Yield each goal that is not met, and what was reached."""
    for row in ROWS:
        measured = run.lines.get(row.line.name)
        for verdict in judge(measured) if measured else ():
            goal = verdict.goal
            if goal.figure in row.figures and verdict.met is False and verdict.multiple is not None:
                sign = '≥' if goal.at_least else '≤'
                yield (
                    f'- {measured.line.name if measured else ""}, {goal.figure}, {GOALWIRE[verdict.subject]}:'
                    f' {verdict.multiple:.3g}{OF[goal.of]}, asked {sign} {verdict.limit:g}'
                )


def filled(page: str, parts: Mapping[str, str]) -> str:
    """Return the page with the parts between their comments. Raises SystemExit if comments are missing."""
    for name, text in parts.items():
        before, begin, rest = page.partition(f'<!-- bench: {name} -->\n')
        _, end, after = rest.partition('<!-- bench: end -->')
        if not end:
            sys.exit(f'the page has no place for {name}')
        page = f'{before}{begin}{text}\n{end}{after}'
    return page


def main(report: Path = REPORT) -> None:
    """Write the page and its picture."""
    run = read(report)
    parts = {'head': '\n'.join(head(run)), 'tables': '\n'.join(tables(run))}
    PAGE.write_text(filled(PAGE.read_text(encoding='utf-8'), parts), encoding='utf-8')
    from tools import pictures

    pictures.SPEED.write_text(pictures.speed(), encoding='utf-8')


if __name__ == '__main__':
    main(*map(Path, sys.argv[1:]))
