"""The keystore, the routers, the links and the robots of one simulated fleet."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from collections import Counter
from collections.abc import Sequence
from contextlib import ExitStack
from pathlib import Path
from typing import Any

from helpers.isolation import free_port, isolated_env

from benchmarks.fleet.programs import ROBOTS
from goalwire.security.environment import Chosen
from goalwire.security.keystore import Keystore
from goalwire.transport.zenoh.settings import fleet, secured_rmw_zenoh

CLOUD = 'cloud'
CONNECT_MS = 600_000
"""How long a session keeps trying: routers are slow while many robots come at once."""
_HOST = 'tls/127.0.0.1'


class Layout:
    """A cloud, sites that dial it, robots that dial the sites in turn, and an operator at the cloud."""

    def __init__(
        self,
        folder: Path,
        robots: int,
        offers: str,
        sites: int,
        per_process: int,
        links: Sequence[str],
        stack: ExitStack,
    ) -> None:
        """Write the keystore and the settings. `links` are options of slow_links, if it relays the links.

        `offers` says which names of the humanoid each robot has: 'all' or 'few'.
        """
        self.folder = folder
        self.robots = robots
        self._offers = offers
        self.sites = [f'site-{number}' for number in range(sites)]
        self.per_process = per_process
        self.running: dict[str, subprocess.Popen[str]] = {}
        """The routers by name."""
        self.relays: dict[str, subprocess.Popen[str]] = {}
        """The relay before each router, by the router's name."""
        self._stack = stack
        self._keystore = Keystore.create(folder / 'keys')
        self._listens = {name: free_port() for name in (CLOUD, *self.sites)}
        self._dialled = {name: self._relay(name, port, links) for name, port in self._listens.items()}
        robots_of = {site: self._robots_of(number) for number, site in enumerate(self.sites)}
        for name, kind in [(name, 'router') for name in self._listens] + [('ann', 'person')]:
            self._keystore.add(name, kind, ())
        for site, names in robots_of.items():
            for name in names:
                self._keystore.issue(name, 'robot')  # the routers' rules name it, and no policy is asked
                self._write_session(name, self._dialled[site])
        self._write_session('ann', self._listens[CLOUD])
        self._write_router(CLOUD, [], [], ['ann', *self.sites])
        for site, names in robots_of.items():
            self._write_router(site, [f'{_HOST}:{self._dialled[CLOUD]}'], names, [CLOUD])

    def _robots_of(self, site: int) -> list[str]:
        return [f'r{number}' for number in range(site, self.robots, len(self.sites))]

    def _identity(self, name: str) -> Chosen:
        return Chosen(self.folder / 'keys', name)

    def _write_session(self, name: str, port: int) -> None:
        settings = secured_rmw_zenoh.session_settings(self._identity(name), f'{_HOST}:{port}')
        settings['connect'] = {'endpoints': [f'{_HOST}:{port}'], 'timeout_ms': CONNECT_MS}
        self._write(name, settings)

    def _write_router(self, name: str, dials: list[str], robots: list[str], others: list[str]) -> None:
        listens = [f'{_HOST}:{self._listens[name]}']
        self._write(name, fleet.site_router(self._identity(name), listens, dials, robots, others))

    def _write(self, name: str, settings: Any) -> None:
        (self.folder / f'{name}.json5').write_text(json.dumps(settings), encoding='utf-8')

    def _relay(self, name: str, server_port: int, links: Sequence[str]) -> int:
        """Return the port at which a router is dialled: its own, or that of a relay before it."""
        if not links:
            return server_port
        port = free_port()
        words = ['-m', 'benchmarks.fleet.slow_links', str(port), str(server_port), *links]
        self.relays[name] = self._start([*words, '--control'], 'ready')
        return port

    # -- programs --------------------------------------------------------------------------------------------

    def begin_routers(self) -> None:
        """Start all routers, and wait until they listen."""
        for name in self._listens:
            self.begin_router(name)

    def begin_router(self, name: str) -> None:
        """Start a router, and wait until it listens."""
        settings = str(self.folder / f'{name}.json5')
        words = ['-m', 'goalwire', 'router']
        self.running[name] = self._start(words, 'router', ZENOH_ROUTER_CONFIG_URI=settings)

    def kill_router(self, name: str) -> None:
        """Kill a router (kill -9)."""
        router = self.running.pop(name)
        router.kill()
        router.wait()

    def partition(self, name: str, seconds: float, *, everything: bool) -> None:
        """Let no byte pass for some time on all relayed links to a router, or on one."""
        relay = self.relays[name]
        assert relay.stdin is not None
        relay.stdin.write(f'partition {seconds:.1f} {"all" if everything else "one"}\n')
        relay.stdin.flush()

    def count_faults(self) -> Counter[str]:
        """Return how many stalls, breaks and partitions all relayed links have had."""
        total: Counter[str] = Counter()
        for relay in self.relays.values():
            assert relay.stdin is not None
            assert relay.stdout is not None
            relay.stdin.write('count\n')
            relay.stdin.flush()
            total.update(json.loads(relay.stdout.readline()))
        return total

    def serve(self) -> list[subprocess.Popen[str]]:
        """Start the robots, and wait until they serve."""
        programs = []
        for first in range(0, self.robots, self.per_process):
            last = min(first + self.per_process, self.robots)
            programs.append(
                self._start(['-c', ROBOTS, str(self.folder), str(first), str(last), self._offers])
            )
        for each in programs:
            expect(each, 'ready')
        return programs

    def operate(self, program: str, *arguments: str, begins: str = '') -> subprocess.Popen[str]:
        """Start a program of the operator's; wait until it prints `begins`."""
        settings = str(self.folder / 'ann.json5')
        return self._start(['-c', program, *arguments], begins, ZENOH_SESSION_CONFIG_URI=settings)

    def _start(self, words: list[str], begins: str = '', **variables: str) -> subprocess.Popen[str]:
        env = {**isolated_env('rmw_zenoh_cpp'), **variables, 'ROS_DOMAIN_ID': '7', 'GOALWIRE_ROUTER': 'off'}
        started = subprocess.Popen(
            [sys.executable, *words], env=env, text=True, stdin=subprocess.PIPE, stdout=subprocess.PIPE
        )
        self._stack.callback(started.wait)
        self._stack.callback(started.kill)
        if begins:
            expect(started, begins)
        return started

    def runs(self) -> Counter[str]:
        """Return how often each goal was begun so far, by the robots' file."""
        executed = self.folder / 'executed'
        return Counter(executed.read_text(encoding='utf-8').split() if executed.exists() else ())


def expect(program: subprocess.Popen[str], text: str) -> None:
    """Wait until a program prints a line with this text."""
    assert program.stdout is not None
    while text not in (line := program.stdout.readline()):
        assert line, f'{program.args!r:.300} has ended with {program.wait()}'


def last_line(program: subprocess.Popen[str], timeout_s: float = 1000.0) -> Any:
    """Return what a program prints at its end, read as JSON."""
    out, _ = program.communicate(timeout=timeout_s)
    lines = out.splitlines()
    if not lines:
        raise SystemExit(f'{program.args!r:.80}... has ended with {program.returncode}, and without figures')
    return json.loads(lines[-1])


def memory_mb(program: subprocess.Popen[str]) -> float:
    """Return a process's resident memory."""
    text = Path(f'/proc/{program.pid}/statm').read_text(encoding='utf-8')
    return int(text.split()[1]) * os.sysconf('SC_PAGE_SIZE') / 1e6


def cpu_s(program: subprocess.Popen[str]) -> float:
    """Return the processor time of a process so far."""
    fields = Path(f'/proc/{program.pid}/stat').read_text(encoding='utf-8').rpartition(')')[2].split()
    return (int(fields[11]) + int(fields[12])) / os.sysconf('SC_CLK_TCK')


def ask_robot(program: subprocess.Popen[str]) -> int:
    """Return how many tokens one robot's session has been sent."""
    assert program.stdin is not None
    assert program.stdout is not None
    program.stdin.write('how many\n')
    program.stdin.flush()
    return int(program.stdout.readline())
