"""python -m benchmarks.command_line: how long commands take from start to end, beside running nodes.

usage: python -m benchmarks.command_line [--runs N] [--nodes N] [--processes N]

Prints a table in Markdown. The limits are the project's own: `ros2 --help` 120 ms, `ros2 service list` 250 ms
with 20 nodes. The column of ros2cli holds what its users report; it was not measured here.
"""

from __future__ import annotations

import argparse
import os
import resource
import subprocess
import sys
from contextlib import ExitStack
from pathlib import Path
from statistics import median
from time import perf_counter
from typing import NamedTuple

ROS2 = Path(sys.executable).with_name('ros2')
WIRES = ('rmw_zenoh_cpp', 'rmw_cyclonedds_cpp')
COMMANDS: tuple[tuple[str, ...], ...] = (
    ('--help',),
    ('service', 'list'),
    ('topic', 'list', '-t'),
    ('node', 'info', '/node0_0'),
)
LIMITS_MS: dict[tuple[str, ...], float] = {('--help',): 120.0, ('service', 'list'): 250.0}
ROS2CLI_MS: dict[tuple[str, ...], float] = {('service', 'list'): 1100.0}
"""Of Jazzy, without a daemon that runs already."""
COLUMNS = ('wire', 'command', 'median', 'fastest', 'CPU', 'lines', 'limit', 'ros2cli')
WIDTHS = (18, 20, 6, 7, 4, 5, 10, 7)
NODES = """
import sys
import rclpy
from rclpy.executors import SingleThreadedExecutor
from std_srvs.srv import Trigger
rclpy.init()
executor = SingleThreadedExecutor()
for number in range(int(sys.argv[2])):
    node = rclpy.create_node(f'node{sys.argv[1]}_{number}')
    node.create_service(Trigger, f'service{sys.argv[1]}_{number}', lambda request, response: response)
    executor.add_node(node)
print('ready', flush=True)
executor.spin()
"""


class Took(NamedTuple):
    """The durations of runs of a command, in ms."""

    median: float
    fastest: float
    cpu: float
    lines: int
    """Printed, at least."""


def took(command: tuple[str, ...], env: dict[str, str], runs: int) -> Took:
    """Run a command again and again."""
    times, cpu, lines = [], [], []
    for number in range(runs + 1):
        began, used = perf_counter(), _cpu_of_children()
        done = subprocess.run([ROS2, *command], env=env, capture_output=True, check=True)
        if number == 0:
            continue  # it has compiled what was not compiled yet
        times.append((perf_counter() - began) * 1000)
        cpu.append((_cpu_of_children() - used) * 1000)
        lines.append(done.stdout.count(b'\n'))
    return Took(median(times), min(times), median(cpu), min(lines))


def _cpu_of_children() -> float:
    usage = resource.getrusage(resource.RUSAGE_CHILDREN)
    return usage.ru_utime + usage.ru_stime


def measure(wire: str, options: argparse.Namespace) -> bool:
    """Print the figures of one wire; whether the limits are kept."""
    env = {
        **{name: value for name, value in os.environ.items() if name != 'PYTHONDONTWRITEBYTECODE'},
        'RMW_IMPLEMENTATION': wire,
        'ROS_DOMAIN_ID': '97',
        'ROS_AUTOMATIC_DISCOVERY_RANGE': 'LOCALHOST',
        'GOALWIRE_ROUTER_PORT': '17449',
    }
    kept = True
    with ExitStack() as stack:
        for number in range(options.processes):
            share = options.nodes // options.processes
            program = [sys.executable, '-c', NODES, str(number), str(share)]
            process = stack.enter_context(subprocess.Popen(program, env=env, stdout=subprocess.PIPE))
            stack.callback(process.kill)
            assert process.stdout is not None
            process.stdout.readline()
        for command in COMMANDS:
            runs, limit = took(command, env, options.runs), LIMITS_MS.get(command)
            is_kept = limit is None or runs.median <= limit
            kept = kept and is_kept
            _print_row(
                wire,
                ' '.join(command),
                f'{runs.median:.0f}',
                f'{runs.fastest:.0f}',
                f'{runs.cpu:.0f}',
                str(runs.lines),
                '' if limit is None else f'{limit:.0f} {"kept" if is_kept else "MISSED"}',
                f'~{ROS2CLI_MS[command]:.0f}' if command in ROS2CLI_MS else '',
            )
    return kept


def _print_row(*cells: str) -> None:
    padded = (
        f'{cell:{width}}' if at < 2 else f'{cell:>{width}}'
        for at, (cell, width) in enumerate(zip(cells, WIDTHS, strict=True))
    )
    print(f'| {" | ".join(padded)} |', flush=True)


def main() -> int:
    """Measure; return 1 if a limit is missed."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument('--runs', type=int, default=15)
    parser.add_argument('--nodes', type=int, default=20)
    parser.add_argument('--processes', type=int, default=20)
    options = parser.parse_args()
    print(f'{options.nodes} nodes in {options.processes} processes, {options.runs} runs each; ms\n')
    _print_row(*COLUMNS)
    _print_row(*('-' * width for width in WIDTHS))
    kept = [measure(wire, options) for wire in WIRES]  # both, also where the first one misses a limit
    return 0 if all(kept) else 1


if __name__ == '__main__':
    sys.exit(main())
