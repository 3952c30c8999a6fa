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


WHO = ('goalwire', 'raw Zenoh', 'raw tuned')
"""goalwire; Zenoh without goalwire, as it comes; the same with goalwire's settings of Zenoh's threads."""

LINES: dict[str, tuple[str, Callable[..., list[float]]]] = {
    'service call, call_async + spin_until_future_complete': ('service', wire.raw_service_round_trip),
    'topic round trip, PoseStamped, callbacks both sides': ('topic', wire.raw_topic_round_trip),
}


def run(rounds: int, calls: int) -> list[dict[str, object]]:
    """Measure every line, alternating: medians over the rounds, µs; ratios are each round's own."""
    results: list[dict[str, object]] = []
    for name, (what, raw) in LINES.items():
        measured: dict[str, list[list[float]]] = {who: [] for who in WHO}
        for _ in range(rounds):
            measured['goalwire'].append(goalwire_times(what, calls))
            measured['raw Zenoh'].append(raw(calls, tuned=False))
            measured['raw tuned'].append(raw(calls, tuned=True))
        p50 = {who: [percentile(times, 0.5) for times in measured[who]] for who in WHO}
        row: dict[str, object] = {'work': name}
        for who in WHO:
            row[f'{who} p50'] = median(p50[who])
            row[f'{who} p99'] = median(percentile(times, 0.99) for times in measured[who])
        for who in WHO[1:]:
            row[f'/ {who}'] = median(a / b for a, b in zip(p50['goalwire'], p50[who], strict=True))
        results.append(row)
    return results


def report(results: list[dict[str, object]]) -> None:
    """Print the table."""
    from rich.console import Console
    from rich.table import Table

    table = Table(title=f'Round trips between two processes, Zenoh, Python {platform.python_version()} (µs)')
    table.add_column('work')
    times = [f'{who} {share}' for who in WHO for share in ('p50', 'p99')]
    ratios = [f'/ {who}' for who in WHO[1:]]
    for column in (*times, *ratios):
        table.add_column(column, justify='right')
    for row in results:
        table.add_row(
            str(row['work']),
            *(f'{row[column]:.0f}' for column in times),
            *(f'{row[column]:.2f}' for column in ratios),
        )
    Console(width=150).print(table)


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
