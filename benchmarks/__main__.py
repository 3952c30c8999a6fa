"""make bench: goalwire on each of its wires, the real rclpy and the raw wires beside it, in one run.

usage: python -m benchmarks [--rounds N] [--scale X] [--only WORD] [--alone] [--out FOLDER]
       python -m benchmarks --curves | --short
"""

from __future__ import annotations

import argparse
import json
import sys
from collections.abc import Iterable
from pathlib import Path
from time import monotonic

from benchmarks import ROOT, curves, machine, markdown, short, svg
from benchmarks.line import Line
from benchmarks.measuring import Measured, measure
from benchmarks.subjects import PEER, Subject, everybody
from benchmarks.table import LINES
from benchmarks.verdicts import judge


def say(text: str) -> None:
    """Show the work that is under way, if somebody watches."""
    if sys.stderr.isatty():
        print(f'\r{text[:100]:100}', end='', file=sys.stderr, flush=True)


def table(lines: Iterable[Line], subjects: list[Subject], rounds: int | None, scale: float) -> list[Measured]:
    """Measure the lines."""
    results = []
    for line in lines:
        count = max(int(line.operations * scale), 1)
        results.append(measure(line, subjects, rounds or line.rounds, count, say))
    return results


def picture(results: Iterable[Measured]) -> str:
    """Return the plot: each line's first figure as a multiple of the real rclpy's, less is better."""
    shown: dict[str, dict[str, float]] = {}
    for result in results:
        name = result.line.figures[0]
        upside_down = any(goal.at_least for goal in result.line.goals if goal.figure == name)
        base = result.figure(PEER, name) or result.line.reference.get(name)
        if not base:
            continue
        subjects = [subject for subject in result.rounds if subject in markdown.GOALWIRE]
        figures = {subject: result.figure(subject, name) or 0.0 for subject in subjects}
        row = {who: base / value if upside_down else value / base for who, value in figures.items() if value}
        shown[f'{result.line.name.replace("`", "")}, {name}'] = row
    title = 'Time (or the inverse of a rate) as a multiple of the real rclpy, measured beside: less is better'
    return svg.rows(title, 'multiple of the real rclpy on Fast DDS', shown)


def write(folder: Path, results: list[Measured], facts: dict[str, str], no_peer: str) -> None:
    """Write the report in its three forms."""
    folder.mkdir(parents=True, exist_ok=True)
    text = markdown.report(facts, results, no_peer)
    (folder / 'report.md').write_text(text, encoding='utf-8')
    (folder / 'report.svg').write_text(picture(results), encoding='utf-8')
    raw = {
        'facts': facts,
        'lines': {
            result.line.name: {
                'rounds': result.rounds,
                'failures': result.failures,
                'goals': [
                    verdict._asdict() | {'goal': str(verdict.goal), 'met': verdict.met}
                    for verdict in judge(result)
                ],
            }
            for result in results
        },
    }
    (folder / 'report.json').write_text(json.dumps(raw, indent=1), encoding='utf-8')
    print(text)
    print(f'python -m benchmarks.page {folder / "report.json"} puts these figures into performance.md')


def main() -> int:
    """Measure and report."""
    parser = argparse.ArgumentParser(prog='python -m benchmarks', description=(__doc__ or '').splitlines()[0])
    parser.add_argument('--rounds', type=int, help="in place of each line's own number")
    parser.add_argument('--scale', type=float, default=1.0, help='of the numbers of operations')
    parser.add_argument('--only', default='', metavar='WORD', help='lines whose program has WORD in its name')
    parser.add_argument(
        '--out', type=Path, metavar='FOLDER', help='build/bench, for curves docs/reference/performance'
    )
    parser.add_argument('--alone', action='store_true', help='without the real rclpy')
    parser.add_argument('--curves', action='store_true', help='how it scales, as plots')
    parser.add_argument('--short', action='store_true', help='ratios alone, against those expected: for CI')
    options = parser.parse_args()
    if options.short:
        return short.main()
    if options.curves:
        return curves.main(
            options.out or ROOT / 'docs' / 'reference' / 'performance', options.scale, options.only
        )
    begun = monotonic()
    facts = machine.facts()
    lines = [line for line in LINES if options.only in line.module]
    if not lines:
        names = ', '.join(line.module.rpartition('.')[2] for line in LINES)
        parser.error(f"no line's program has {options.only!r} in its name; there are {names}")
    subjects, no_peer = everybody(with_peers=not options.alone)
    results = table(lines, subjects, options.rounds, options.scale)
    write(
        options.out or ROOT / 'build' / 'bench',
        results,
        facts | {'taken': f'{monotonic() - begun:.0f} s'},
        no_peer,
    )
    return 0


if __name__ == '__main__':
    sys.exit(main())
