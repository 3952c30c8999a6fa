"""A table of what goalwire's own DDS session and other implementations can do for each other.

usage: python -m benchmarks.vendor_matrix [--old-libddsc FILE] [--calls N] [--goals N] [WORD ...]

Each peer serves our client and calls our server: topics from 1 B to 16 MB, a latched topic, a service with
three clients, parameters, goals with feedback of which half are cancelled, sixteen pairs of QoS, events, the
graph. WORDs pick peers. They come from the package index. Version 0.10 of libddsc has no wheel for today's
Python, so its library is named.
"""

from __future__ import annotations

import argparse
import os
import re
import signal
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import NamedTuple

from helpers import real_rclpy
from helpers.environments import CannotInstall, Environment
from helpers.isolation import isolated_env
from helpers.processes import Program

from benchmarks import ROOT
from goalwire.idl.search_path import SHIPPED
from goalwire.transport.dds import CHOICE, CYCLONE, NATIVE

PROGRAMS = ROOT / 'tests' / 'interop' / 'programs'
FAST_DDS, CYCLONE_DDS = 'rmw_fastrtps_cpp', 'rmw_cyclonedds_cpp'
LARGEST = 16_000_000
USES = ('graph', 'topics', 'latched', 'services', 'parameters', 'goals', 'qos', 'events')
OF_RUSTDDS = ('topics', 'latched', 'services', 'parameters', 'goals', 'qos')
PATIENCE_S = 180.0
_NO_SHARED_MEMORY = """#!/bin/sh
exec unshare --mount sh -c 'mount -t tmpfs -o ro none /dev/shm && exec "$@"' sh {python} "$@"
"""
"""rmw_fastrtps makes its transports itself, so no setting keeps Fast DDS from shared memory."""


class Peer(NamedTuple):
    """One implementation: how its programs are started, and what they are asked."""

    name: str
    python: Path
    rmw: str
    env: dict[str, str]
    ours: dict[str, str]
    is_rust: bool = False


def find_peers(old_libddsc: str) -> Iterator[Peer]:
    """Yield the peers that can be had here; those that cannot are named on the standard error stream."""
    here = Path(sys.executable)
    yield Peer('libddsc 11', here, CYCLONE_DDS, {CHOICE: CYCLONE}, {})
    if old_libddsc:
        env = {CHOICE: CYCLONE, 'GOALWIRE_LIBDDSC': old_libddsc}
        yield Peer('libddsc 0.10', here, CYCLONE_DDS, env, {})
    for title, wheels in (('Kilted, 9.1.2', real_rclpy.KILTED), ('Jazzy, 7.1.6', real_rclpy.WHEELS)):
        python = _install(*wheels)
        if python is not None:
            definitions = {'AMENT_PREFIX_PATH': str(python.parents[1])}
            name = f'rclpy of {title}, on Fast DDS'
            yield Peer(name, python, FAST_DDS, {}, definitions)
            if hasattr(os, 'geteuid') and os.geteuid() == 0:
                alone = _without_shared_memory(python)
                yield Peer(f'{name}, UDP alone', alone, FAST_DDS, {}, definitions)
    rust = _install('roswell==0.1.0')
    if rust is not None:
        yield Peer('RustDDS, by roswell 0.1.0', rust, FAST_DDS, {}, {}, is_rust=True)


def _install(*wheels: str) -> Path | None:
    title = '-'.join([str(sys.implementation.cache_tag), *wheels]).replace('==', '-')
    folder = ROOT / 'build' / 'peers'
    folder.mkdir(parents=True, exist_ok=True)
    try:
        return Environment.kept(folder / title, *wheels).python
    except CannotInstall as error:
        print(f'{wheels[0]}: {error}', file=sys.stderr)
        return None


def _without_shared_memory(python: Path) -> Path:
    """Return a program that runs an interpreter without shared memory; only root can use it."""
    script = python.with_name('python-without-shared-memory')
    script.write_text(_NO_SHARED_MEMORY.format(python=python.absolute()), encoding='utf-8')
    script.chmod(0o755)
    return script


class Way(NamedTuple):
    """One direction: the programs of a server and a client, each with what starts it."""

    server: tuple[list[str], dict[str, str]]
    client: tuple[list[str], dict[str, str]]
    uses: tuple[str, ...]


def find_ways(peer: Peer, calls: int, goals: int) -> tuple[Way, Way]:
    """Return a peer as the server and as the client."""
    shared = isolated_env(peer.rmw)
    ours = shared | {'RMW_IMPLEMENTATION': peer.rmw, CHOICE: NATIVE} | peer.ours
    theirs = shared | {'RMW_IMPLEMENTATION': peer.rmw} | peer.env
    us, them = sys.executable, str(peer.python)
    counts = [str(calls), str(goals)]
    server, client = str(PROGRAMS / 'vendor_server.py'), str(PROGRAMS / 'vendor_client.py')
    if not peer.is_rust:
        size = str(LARGEST)
        return (
            Way(([them, server, size], theirs), ([us, client, *counts, size], ours), USES),
            Way(([us, server, size], ours), ([them, client, *counts, size], theirs), USES),
        )
    # RustDDS puts no sample of several fragments together in a reply, and writes none; its nodes do not tell
    # which endpoints are theirs; roswell has no events.
    serves = [them, str(PROGRAMS / 'roswell_server.py'), str(SHIPPED), '1000']
    asks = [them, str(PROGRAMS / 'roswell_client.py'), str(SHIPPED), *counts, '50000']
    small = [us, client, *counts, '1000', 'no-graph', 'no-events']
    return (
        Way((serves, theirs), (small, ours), OF_RUSTDDS),
        Way(([us, server, '50000'], ours), (asks, theirs), ('topics', 'latched', 'services', 'goals')),
    )


def play(way: Way) -> dict[str, str]:
    """Return what a client found right of each use, as 'n of m'."""
    command, env = way.server
    with Program(Path(command[1]), *command[2:], env=env, python=Path(command[0])) as serving:
        serving.expect('ready', PATIENCE_S)
        command, env = way.client
        with Program(Path(command[1]), *command[2:], env=env, python=Path(command[0])) as calling:
            found = {}
            for use in way.uses:
                try:
                    found[use] = ' of '.join(calling.expect(rf'^{use} (\d+) of (\d+)', PATIENCE_S).groups())
                except AssertionError:
                    found[use] = 'nothing'
        serving.send_signal(signal.SIGINT)
    return found


def main() -> int:
    parser = argparse.ArgumentParser(description=(__doc__ or '').partition('\n')[0])
    parser.add_argument('words', nargs='*')
    parser.add_argument('--old-libddsc', default='')
    parser.add_argument('--calls', type=int, default=200)
    parser.add_argument('--goals', type=int, default=10)
    options = parser.parse_args()
    print(f'| peer | it is | {" | ".join(USES)} |\n|---|---|{"---|" * len(USES)}', flush=True)
    right = of = 0
    for peer in find_peers(options.old_libddsc):
        if not all(word in peer.name for word in options.words):
            continue
        for side, way in zip(
            ('server', 'client'), find_ways(peer, options.calls, options.goals), strict=True
        ):
            found = play(way)
            cells = [found.get(use, '') for use in USES]
            print(f'| {peer.name} | {side} | {" | ".join(cells)} |', flush=True)
            for cell in filter(None, cells):
                counted = re.fullmatch(r'(\d+) of (\d+)', cell)
                of += 1
                right += counted is not None and counted[1] == counted[2]
    print(f'\n{right} of {of} cells are whole.')
    return int(right < of)


if __name__ == '__main__':
    sys.exit(main())
