"""The recipe of examples/fleet_missions under fire: python -m benchmarks.fleet_missions [--missions 1000].

Needs Postgres and dbos. Simulated robots, each with a Zenoh session of its own, a few in a process; the
engine's workers are killed (kill -9) in turn, Postgres is restarted, and one of the robots' programs is
killed now and then. At last the robots' own files are read: which missions began and ended where.
"""

from __future__ import annotations

import argparse
import sys
import tempfile
import threading
import time
from collections import Counter
from collections.abc import Iterator
from contextlib import ExitStack, suppress
from importlib.util import find_spec
from pathlib import Path
from typing import NamedTuple

from helpers.forking import ForkServer
from helpers.isolation import isolated_env
from helpers.markdown import ROOT
from helpers.postgres import Postgres, find_programs, postgres
from helpers.processes import Program

EXAMPLE = ROOT / 'examples' / 'fleet_missions'
WORKERS = 3
PRELOADED = (
    'dbos',
    'example_interfaces.action',
    'goalwire.aio',
    'goalwire.entities.actions.journal_file',
    'goalwire.missions',
    'psycopg',
)
"""The modules that the programs import: a worker that starts would need seconds of a core for them."""
START_S = 300.0
CONNECT_MS = 60_000
"""How long a session keeps trying: the router is slow on a busy machine while many robots come."""


class Plan(NamedTuple):
    """How large the fleet is, and what happens to it."""

    missions: int = 1000
    robots: int = 100
    per_process: int = 25
    kill_every: float = 5.0
    """Seconds between two kills of a worker."""
    restarts: int = 10
    """How often Postgres is restarted: as many missions end before each restart, and after the last one."""
    worker_kills: int = 1_000_000
    """After so many kills the workers are left alone."""
    robot_kills: int = 4
    """How often a program of robots is killed; one follows each second restart of Postgres."""


class Count(NamedTuple):
    """The counts in the robots' files."""

    begun: Counter[int]
    """How often each mission's drive began."""
    ended: Counter[int]
    """How often each mission's drive ended."""
    on: dict[int, set[str]]
    """The robots that had each mission."""
    overlaps: int
    """How often a robot began a mission while it had another one."""


def count(folder: Path) -> Count:
    """Read the robots' files."""
    found = Count(Counter(), Counter(), {}, 0)
    overlaps = 0
    for file in folder.glob('r*.log'):
        under_way: int | None = None
        for line in file.read_text(encoding='utf-8').splitlines():
            word, _, number = line.partition(' ')
            mission = int(number)
            found.on.setdefault(mission, set()).add(file.stem)
            overlaps += under_way not in {None, mission}
            under_way = mission if word == 'begin' else None
            (found.begun if word == 'begin' else found.ended)[mission] += 1
    return found._replace(overlaps=overlaps)


def is_ready(program: Program) -> bool:
    """Return whether a program has said that it is ready, and has not ended."""
    return 'ready' in program.output.splitlines() and not has_ended(program)


def has_ended(program: Program) -> bool:
    """Return whether a program has ended."""
    with suppress(AssertionError):
        program.wait(0.0)
        return True
    return False


class Site:
    """The processes of one run."""

    def __init__(self, plan: Plan, database: Postgres, folder: Path, stack: ExitStack) -> None:
        self.plan = plan
        self.folder = folder
        self.kills: Counter[str] = Counter()
        self._database = database
        self._stack = stack
        env = isolated_env('rmw_zenoh_cpp')
        port = env['GOALWIRE_ROUTER_PORT']
        client = f'mode="client";connect/endpoints=["tcp/127.0.0.1:{port}"];connect/timeout_ms={CONNECT_MS}'
        self._env = {**env, 'GOALWIRE_ROUTER': 'off', 'ZENOH_CONFIG_OVERRIDE': client}
        router = stack.enter_context(Program(Path('-m'), 'goalwire', 'router', env=env, cwd=folder))
        router.expect('listens on', START_S)
        self._server = stack.enter_context(ForkServer(PRELOADED, self._env))
        self._robots = [self._begin_robots(first) for first in range(0, plan.robots, plan.per_process)]
        for each in self._robots:
            each.expect('^ready', START_S)
        self._workers = [self._begin_worker(number) for number in range(WORKERS)]
        for each in self._workers:
            each.expect('^ready', START_S)
        self._turns = list(range(WORKERS))

    def _start(self, source: Path, *arguments: str) -> Program:
        program = Program(source, *arguments, env=self._env, cwd=self.folder, server=self._server)
        return self._stack.enter_context(program)

    def _begin_robots(self, first: int) -> Program:
        last = min(first + self.plan.per_process, self.plan.robots)
        return self._start(EXAMPLE / 'robots.py', str(self.folder), str(first), str(last))

    def _begin_worker(self, number: int) -> Program:
        return self._start(EXAMPLE / 'worker.py', self._database.url, f'worker-{number}')

    def order(self) -> None:
        """Order the missions: each fourth one needs a robot that lifts."""
        lifts = self.plan.missions // 4
        for skill, first, last in (('lift', 0, lifts), ('carry', lifts, self.plan.missions)):
            ordering = self._run_orders('order', skill, str(first), str(last))
            ordering.succeed(START_S)

    def states(self) -> dict[str, int]:
        """Return how many missions the engine has in each state."""
        lines = self._run_orders('show').succeed(START_S).splitlines()
        found = (line.rsplit(' ', 1) for line in lines)
        return {state: int(number) for state, number in found if state.isupper()}

    def _run_orders(self, *arguments: str) -> Program:
        return self._start(EXAMPLE / 'orders.py', self._database.url, *arguments)

    def kill_worker(self) -> None:
        """Kill the worker that has served longest, and start it again under its name.

        A worker that still starts is spared: on a busy machine none would ever serve otherwise.
        """
        serving = [number for number in self._turns if is_ready(self._workers[number])]
        if not serving:
            return
        number = serving[0]
        self._turns.remove(number)
        self._turns.append(number)
        self.kills['worker'] += 1
        self._workers[number].close()
        self._workers[number] = self._begin_worker(number)

    def supervise(self) -> None:
        """Start again what has ended by itself, as a worker does that finds no Postgres at its start."""
        for number, worker in enumerate(self._workers):
            if has_ended(worker):
                self.kills['ended by itself: worker'] += 1
                worker.close()
                self._workers[number] = self._begin_worker(number)
        for number, robots in enumerate(self._robots):
            if has_ended(robots):
                self.kills['ended by itself: robots'] += 1
                robots.close()
                self._robots[number] = self._begin_robots(number * self.plan.per_process)

    def restart_database(self) -> None:
        """End Postgres, in turn as an administrator and as a crash does, and start it again."""
        self.kills['Postgres'] += 1
        self._database.stop('immediate' if self.kills['Postgres'] % 2 else 'fast')
        self._database.start()

    def kill_robots(self) -> None:
        """Kill one program of robots, and start it again."""
        number = self.kills['robots'] % len(self._robots)
        self.kills['robots'] += 1
        self._robots[number].close()
        self._robots[number] = self._begin_robots(number * self.plan.per_process)


def disturb(site: Site, is_over: threading.Event) -> None:
    """Kill and restart by the plan, until the missions have ended."""
    plan = site.plan
    while not is_over.wait(plan.kill_every):
        site.supervise()
        if site.kills['worker'] < plan.worker_kills:
            site.kill_worker()
        share = len(count(site.folder).ended) / plan.missions
        restart = site.kills['Postgres'] + 1
        if restart <= plan.restarts and share >= restart / (plan.restarts + 1):
            site.restart_database()
            if site.kills['Postgres'] % 2 == 0 and site.kills['robots'] < plan.robot_kills:
                site.kill_robots()


def _look(site: Site) -> Iterator[int]:
    """Yield how many missions have ended, once a second, by the robots' files."""
    while True:
        yield len(count(site.folder).ended)
        time.sleep(1.0)


def carry_out(plan: Plan, stack: ExitStack, patience: float) -> tuple[Site, Count, dict[str, int], float]:
    """Have a fleet carry out the missions while it is disturbed.

    Returns the site, the robots' count, the engine's, and the seconds. The disturbances end with the last
    drive; the engine then learns of the last ends in peace.
    """
    programs = find_programs()
    assert find_spec('dbos') is not None, f'dbos is not installed: {sys.executable} -m pip install dbos'
    assert programs is not None, 'Postgres is not installed: apt-get install postgresql'
    database = stack.enter_context(postgres(programs))
    folder = Path(stack.enter_context(tempfile.TemporaryDirectory()))
    site = Site(plan, database, folder, stack)
    site.order()
    start, is_over = time.monotonic(), threading.Event()
    thread = threading.Thread(target=disturb, args=(site, is_over))
    thread.start()
    try:
        for ended in _look(site):
            if ended >= plan.missions or time.monotonic() > start + patience:
                break
    finally:
        is_over.set()
        thread.join()
    took = time.monotonic() - start
    states = site.states()
    while states.get('SUCCESS', 0) < plan.missions and time.monotonic() < start + patience:
        time.sleep(1.0)
        site.supervise()
        states = site.states()
    return site, count(folder), states, took


def main() -> int:
    """Print what happened and what was counted."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument('--missions', type=int, default=1000)
    parser.add_argument('--robots', type=int, default=100)
    parser.add_argument('--robot-kills', type=int, default=4)
    parser.add_argument('--patience', type=float, default=1800.0, help='seconds until it gives up')
    chosen = parser.parse_args()
    plan = Plan(chosen.missions, chosen.robots, robot_kills=chosen.robot_kills)
    with ExitStack() as stack:
        site, found, states, took = carry_out(plan, stack, chosen.patience)
    twice = [mission for mission, robots in found.on.items() if len(robots) > 1]
    print(f'{plan.missions} missions, {plan.robots} robots, {took:.0f} s; killed: {dict(site.kills)}')
    print(f'the engine says: {states}')
    print(f'missions by how often they ended: {dict(Counter(found.ended.values()))}')
    print(f'missions by how often they began: {dict(Counter(found.begun.values()))}')
    print(f'missions on two robots: {len(twice)}; robots with two missions: {found.overlaps}')
    return 0 if states == {'SUCCESS': plan.missions} and set(found.ended.values()) == {1} else 1


if __name__ == '__main__':
    sys.exit(main())
