"""make bench-peers: goalwire and what else pip installs for ROS 2, each doing the same works, in one run.

usage: python -m benchmarks.peers [--rounds N] [--scale X] [--only WORD] [--page]

The peers come from the package index, each into an environment of its own below build/peers. `--page` puts
the table into docs/explanation/alternatives.md. What a peer cannot do is a dash; what failed is named.
"""

from __future__ import annotations

import argparse
import os
import sys
from collections.abc import Iterator, Mapping, Sequence
from typing import NamedTuple

from helpers import real_rclpy
from helpers.environments import CannotInstall, Environment

from benchmarks import ROOT, machine, spinning
from benchmarks.line import Line
from benchmarks.markdown import NOTHING, number
from benchmarks.measuring import Measured, measure
from benchmarks.page import filled
from benchmarks.peers.works import ROWS, WORKS
from benchmarks.subjects import NATIVE, Program, Subject, own_program

PAGE = ROOT / 'docs' / 'explanation' / 'alternatives.md'
ROUNDS = 3
FEWEST = 5
"""Operations of a round, whatever the scale."""
ZENOH, FAST_DDS = 'rmw_zenoh_cpp', 'rmw_fastrtps_cpp'
AFOR = 'asyncio-for-robotics==1.5.1'


class Peer(NamedTuple):
    """A package of the index: its program, the works that it can do, and what is installed for it."""

    title: str
    module: str
    works: tuple[str, ...]
    wheels: tuple[str, ...]
    transport: str = ZENOH
    env: Mapping[str, str] = {}


TOPICS_AND_SERVICES = ('service', 'topic', 'start')
CODECS = {'CYDR_CACHE_DIR': str(ROOT / 'build' / 'peers' / 'codecs')}
"""Where pyzeros keeps what it compiles."""
PEERS = (
    Peer(
        'ros-rclpy 9.1.2', '', ('service', 'topic', 'action', 'start'), real_rclpy.NEWEST, FAST_DDS,
        {spinning.SPIN_ONCE: '1'},
    ),
    Peer(
        'asyncio-for-robotics 1.5.1 on ros-rclpy', 'benchmarks.peers.on_asyncio_for_robotics',
        TOPICS_AND_SERVICES, (AFOR, *real_rclpy.NEWEST), FAST_DDS,
    ),
    Peer(
        'pyzeros 0.1.0', 'benchmarks.peers.on_pyzeros', TOPICS_AND_SERVICES,
        ('pyzeros==0.1.0', 'setuptools'), env=CODECS,
    ),
    Peer(
        'zenoh-ros2-sdk 0.1.8', 'benchmarks.peers.on_zenoh_ros2_sdk', TOPICS_AND_SERVICES,
        ('zenoh-ros2-sdk==0.1.8',),
    ),
    Peer(
        'roswell 0.1.0', 'benchmarks.peers.on_roswell', ('service', 'topic', 'action', 'start'),
        ('roswell==0.1.0',),
    ),
    Peer('rosless 0.5.0', 'benchmarks.peers.on_rosless', ('topic',), ('rosless==0.5.0',)),
)  # fmt: skip
GOALWIRE = (
    Subject('goalwire on Zenoh', ZENOH, own_program, NATIVE),
    Subject('goalwire on DDS', FAST_DDS, own_program),
)


def find_peers(word: str) -> Iterator[Subject]:
    """Yield goalwire, and those peers that can be installed; the others are named on the error stream."""
    yield from GOALWIRE
    for peer in PEERS:
        if word not in peer.title:
            continue
        folder = ROOT / 'build' / 'peers'
        folder.mkdir(parents=True, exist_ok=True)
        name = '-'.join([str(sys.implementation.cache_tag), *peer.wheels]).replace('==', '-')
        try:
            python = Environment.kept(folder / name, *peer.wheels).python.absolute()
        except CannotInstall as error:
            print(f'{peer.title}: {error}', file=sys.stderr)
        else:
            yield Subject(peer.title, peer.transport, _program(peer), peer.env, python)


def _program(peer: Peer) -> Program:
    if not peer.module:
        return own_program
    works = {work.line.module: work.name for work in WORKS if work.name in peer.works}

    def program(line: Line) -> list[str]:
        work = works.get(line.module)
        return [peer.module, 'ask', work] if work else []

    return program


def table(results: Mapping[str, Measured], subjects: Sequence[Subject]) -> Iterator[str]:
    """Yield the table: a row for each figure, a column for each subject."""
    yield f'| work | {" | ".join(subject.name for subject in subjects)} |'
    yield f'|---|{"---|" * len(subjects)}'
    for row in ROWS:
        result = results[row.work]
        cells = [_cell(result, subject.name, row.figure) for subject in subjects]
        yield f'| {row.title} | {" | ".join(cells)} |'


def _cell(result: Measured, who: str, figure: str) -> str:
    if who in result.failures:
        return 'failed'
    value = result.figure(who, figure)
    if value is None and figure == 'lost' and who in result.rounds:
        value = 0.0  # on rclpy a start without an answer fails the work
    return NOTHING if value is None else number(value)


def report(
    results: Mapping[str, Measured], subjects: Sequence[Subject], facts: Mapping[str, str], rounds: int
) -> str:
    """Return the table, with what it was measured on before it, and what failed behind it."""
    head = (
        f'Medians of {rounds} rounds of `make bench-peers`, everybody in turn, on {facts["machine"]}, Python '
        f'{facts["Python"]}; load before {facts["load before"]}{_priority()}.'
    )
    failures = [
        f'- {result.line.name}: {text}' for result in results.values() for text in result.failures.values()
    ]
    parts = [head, '', *table(results, subjects)]
    return '\n'.join([*parts, '', 'What failed:', '', *failures] if failures else parts)


def _priority() -> str:
    if hasattr(os, 'sched_getscheduler') and os.sched_getscheduler(0) != os.SCHED_OTHER:
        return '; the measured processes had real-time priority'
    nice = os.getpriority(os.PRIO_PROCESS, 0) if hasattr(os, 'getpriority') else 0
    return f'; the measured processes had the nice value {nice}' if nice else ''


def say(text: str) -> None:
    """Show what is under way."""
    print(text, file=sys.stderr, flush=True)


def main() -> int:
    """Install, measure and print."""
    parser = argparse.ArgumentParser(
        prog='python -m benchmarks.peers', description=(__doc__ or '').splitlines()[0]
    )
    parser.add_argument('--rounds', type=int, default=ROUNDS)
    parser.add_argument('--scale', type=float, default=1.0, help='of the numbers of operations')
    parser.add_argument('--only', default='', metavar='WORD', help='peers with WORD in their name')
    parser.add_argument('--page', action='store_true', help=f'put the table into {PAGE.relative_to(ROOT)}')
    options = parser.parse_args()
    facts = machine.facts()
    subjects = list(find_peers(options.only))
    results = {
        work.name: measure(
            work.line, subjects, options.rounds, max(int(work.operations * options.scale), FEWEST), say
        )
        for work in WORKS
    }
    text = report(results, subjects, facts, options.rounds)
    print(text)
    if options.page:
        PAGE.write_text(filled(PAGE.read_text(encoding='utf-8'), {'peers': text}), encoding='utf-8')
    return 0


if __name__ == '__main__':
    sys.exit(main())
