"""make bench: goalwire's round trips beside the raw wire's, alternating, in one run.

usage: python -m benchmarks [--rounds N] [--calls N] [--json FILE]
"""

from __future__ import annotations

import argparse
import json
import os
import platform
import socket
import subprocess
import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from statistics import median

from benchmarks import wire

ROOT = Path(__file__).resolve().parents[1]


def percentile(times: list[float], share: float) -> float:
    """Return the time below which `share` of them lie, in µs."""
    ordered = sorted(times)
    return ordered[min(int(len(ordered) * share), len(ordered) - 1)] * 1e6


def environment() -> dict[str, str]:
    """Return an environment with a rendezvous and a domain of its own."""
    with socket.socket() as probe:
        probe.bind(('127.0.0.1', 0))
        port = probe.getsockname()[1]
    return {**os.environ, 'GOALWIRE_ROUTER_PORT': str(port), 'ROS_DOMAIN_ID': '97', 'GOALWIRE_ROUTER': 'on'}


@contextmanager
def server(env: dict[str, str]) -> Iterator[None]:
    """Run goalwire's answering process."""
    command = [sys.executable, '-m', 'benchmarks.round_trips', 'server']
    with subprocess.Popen(command, env=env, cwd=ROOT, stdout=subprocess.PIPE, text=True) as process:
        try:
            assert process.stdout is not None
            process.stdout.readline()
            yield
        finally:
            process.terminate()


def goalwire_times(what: str, count: int) -> list[float]:
    """Return goalwire's round-trip times in seconds, between two new processes."""
    env = environment()
    with server(env):
        command = [sys.executable, '-m', 'benchmarks.round_trips', what, str(count)]
        done = subprocess.run(
            command, env=env, cwd=ROOT, check=True, capture_output=True, text=True, timeout=300
        )
    times: list[float] = json.loads(done.stdout)
    return times


LINES: dict[str, tuple[Callable[[int], list[float]], Callable[[int], list[float]]]] = {
    'service call, call_async + spin_until_future_complete': (
        lambda count: goalwire_times('service', count),
        wire.raw_service_round_trip,
    ),
    'topic round trip, PoseStamped, callbacks both sides': (
        lambda count: goalwire_times('topic', count),
        wire.raw_topic_round_trip,
    ),
}


def run(rounds: int, calls: int) -> list[dict[str, object]]:
    """Measure every line: medians over the rounds, µs."""
    results: list[dict[str, object]] = []
    for name, (ours, raw) in LINES.items():
        measured: dict[str, list[list[float]]] = {'goalwire': [], 'raw': []}
        for _ in range(rounds):
            measured['goalwire'].append(ours(calls))
            measured['raw'].append(raw(calls))
        row: dict[str, object] = {'work': name}
        for who, times in measured.items():
            row[f'{who} p50'] = median(percentile(round_, 0.5) for round_ in times)
            row[f'{who} p99'] = median(percentile(round_, 0.99) for round_ in times)
        # The ratio of each round, so that a machine that changes its pace in between does no harm.
        row['ratio'] = median(
            percentile(a, 0.5) / percentile(b, 0.5)
            for a, b in zip(measured['goalwire'], measured['raw'], strict=True)
        )
        results.append(row)
    return results


def report(results: list[dict[str, object]]) -> None:
    """Print the table."""
    from rich.console import Console
    from rich.table import Table

    table = Table(title=f'Round trips between two processes, Zenoh, Python {platform.python_version()}')
    table.add_column('work')
    columns = ('goalwire p50', 'goalwire p99', 'raw p50', 'raw p99')
    for column in columns:
        table.add_column(f'{column} [µs]', justify='right')
    table.add_column('goalwire / raw', justify='right')
    for row in results:
        table.add_row(str(row['work']), *(f'{row[column]:.0f}' for column in columns), f'{row["ratio"]:.2f}')
    Console(width=140).print(table)


def main() -> None:
    """Measure and print; write JSON where asked."""
    parser = argparse.ArgumentParser(prog='python -m benchmarks', description=__doc__)
    parser.add_argument('--rounds', type=int, default=3)
    parser.add_argument('--calls', type=int, default=3000)
    parser.add_argument('--json', type=Path, metavar='FILE')
    options = parser.parse_args()
    results = run(options.rounds, options.calls)
    report(results)
    if options.json:
        options.json.write_text(json.dumps(results, indent=2), encoding='utf-8')


if __name__ == '__main__':
    main()
