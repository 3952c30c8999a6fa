"""A simulated fleet: python -m benchmarks.fleet [--robots 1,10,100].

Robots with the humanoid's names, each with a session and a certificate of its own, 25 in a process, dial the
router of a site. That dials a cloud, and an operator comes to the cloud, all with mutual TLS and the rules of
`goalwire fleet init`. Printed for each number of robots: what the operator's session is sent and the time
until it knows one robot, with `robots=` and without; what one robot's session is sent; memory and processor
time of the routers at rest. At last goals are sent to all robots, and the site's router is killed
(kill -9) and started again meanwhile: how they ended, and how often each was run.
"""

from __future__ import annotations

import argparse
import json
import os
import subprocess
import sys
import tempfile
import time
from collections import Counter
from contextlib import ExitStack
from pathlib import Path
from typing import Any

from helpers.isolation import free_port, isolated_env

from goalwire.security.environment import Chosen
from goalwire.security.keystore import Keystore
from goalwire.transport.zenoh.settings import fleet, secured

PER_PROCESS = 25
REST_S = 5.0
CONNECT_MS = 60_000
"""How long a session keeps trying: routers are slow on a busy machine while many robots come."""

ROBOTS = """
import asyncio, os, sys
import goalwire
from goalwire.entities.context import Context
from example_interfaces.action import Fibonacci
from std_msgs.msg import String
from std_srvs.srv import Trigger

TOPICS = (
    'joint_states odom imu cmd_vel cmd_vel_nav plan map scan clearance world_markers image camera_info '
    'points battery_state emergency_stopped emergency_stop_status joint_command left_wrench right_wrench'
).split()
SERVICES = 'get_joint_state get_battery_status emergency_stop push get_up front_door get_state'.split()
ACTIONS = 'navigate walk left_arm right_arm hands speak'.split()
folder, first, last = sys.argv[1], int(sys.argv[2]), int(sys.argv[3])

async def drive(goal):
    with open(f'{folder}/executed', 'a') as file:
        file.write(goal.goal_id.hex() + chr(10))
    await asyncio.sleep(goal.request.order / 10)
    return Fibonacci.Result(sequence=[1])

async def main():
    nodes = []
    for number in range(first, last):
        os.environ['ZENOH_SESSION_CONFIG_URI'] = f'{folder}/r{number}.json5'
        context = Context()
        context.init([])
        node = goalwire.Node('body', namespace=f'/r{number}', context=context)
        nodes.append(await node.__aenter__())
        for name in TOPICS:
            node.publisher(String, name)
        for name in SERVICES:
            node.service(Trigger, name, lambda _: Trigger.Response())
        for name in ACTIONS:
            node.action_server(Fibonacci, name, drive)
    print('ready', flush=True)
    while await asyncio.to_thread(sys.stdin.readline):
        [link] = nodes[0].context.session._context.wire.session.protocol.links
        print(len(link.peer.tokens), flush=True)

asyncio.run(main())
"""

OPERATOR = """
import asyncio, json, sys, time
import goalwire

async def main():
    start = time.monotonic()
    async with goalwire.Node('eye', robots=sys.argv[1:]) as node:
        changes = node.graph.changes()
        while '/r0/navigate' not in dict(node.graph.served_actions()):
            await anext(changes)
        took = time.monotonic() - start
        [link] = node.context.session._context.wire.session.protocol.links
        seen = len(link.peer.tokens) + len(link.peer.queryables) + len(link.peer.subscribers)
        print(json.dumps([took, seen, time.process_time()]))

asyncio.run(main())
"""

SENDER = """
import asyncio, collections, json, sys
from example_interfaces.action import Fibonacci
from goalwire.fleet import Fleet

async def main():
    names = [f'r{number}' for number in range(int(sys.argv[1]))]
    async with Fleet('dispatch') as fleet:
        await fleet.wait_for(*names, timeout=60)
        print('sends', flush=True)
        reports = await fleet.send(Fibonacci, 'navigate', order=200, parallel=len(names), timeout=300)
        print(json.dumps(collections.Counter(each.status for each in reports)))

asyncio.run(main())
"""


class Site:
    """The keystore, the routers and the robots of one run."""

    def __init__(self, folder: Path, robots: int, stack: ExitStack) -> None:
        self.folder = folder
        self.robots = robots
        self._stack = stack
        self._keystore = Keystore.create(folder / 'keys')
        self._ports = {'cloud': free_port(), 'site': free_port()}
        names = [f'r{number}' for number in range(robots)]
        for name, kind in [('cloud', 'router'), ('site', 'router'), ('ann', 'person')]:
            self._keystore.add(name, kind, ())
        for name in names:
            self._keystore.add(name, 'robot', ())
        for name in ('ann', *names):
            settings = secured.session_settings(self._identity(name), self._address(name))
            settings['connect'] = {'endpoints': [self._address(name)], 'timeout_ms': CONNECT_MS}
            self._write(name, settings)
        listens = {name: [f'tls/127.0.0.1:{port}'] for name, port in self._ports.items()}
        others = ['ann', 'site', 'cloud']
        self._write('cloud', fleet.site_router(self._identity('cloud'), listens['cloud'], [], names, others))
        dials = listens['cloud']
        self._write('site', fleet.site_router(self._identity('site'), listens['site'], dials, names, others))

    def _identity(self, name: str) -> Chosen:
        return Chosen(self.folder / 'keys', name)

    def _address(self, name: str) -> str:
        return f'tls/127.0.0.1:{self._ports["cloud" if name == "ann" else "site"]}'

    def _write(self, name: str, settings: Any) -> None:
        (self.folder / f'{name}.json5').write_text(json.dumps(settings), encoding='utf-8')

    def router(self, name: str) -> subprocess.Popen[str]:
        """Start a router, and wait until it listens."""
        settings = str(self.folder / f'{name}.json5')
        return self._start(['-m', 'goalwire', 'router'], 'router', ZENOH_ROUTER_CONFIG_URI=settings)

    def serve(self) -> list[subprocess.Popen[str]]:
        """Start the robots, and wait until they serve."""
        return [
            self._start(
                ['-c', ROBOTS, str(self.folder), str(first), str(min(first + PER_PROCESS, self.robots))],
                'ready',
            )
            for first in range(0, self.robots, PER_PROCESS)
        ]

    def operate(self, program: str, *arguments: str, begins: str = '') -> subprocess.Popen[str]:
        """Start a program of the operator's."""
        settings = str(self.folder / 'ann.json5')
        return self._start(['-c', program, *arguments], begins, ZENOH_SESSION_CONFIG_URI=settings)

    def _start(self, words: list[str], begins: str, **variables: str) -> subprocess.Popen[str]:
        env = {**isolated_env('rmw_zenoh_cpp'), **variables, 'ROS_DOMAIN_ID': '7', 'GOALWIRE_ROUTER': 'off'}
        started = subprocess.Popen(
            [sys.executable, *words], env=env, text=True, stdin=subprocess.PIPE, stdout=subprocess.PIPE
        )
        self._stack.callback(started.wait)
        self._stack.callback(started.kill)
        assert started.stdout is not None
        while begins and begins not in (line := started.stdout.readline()):
            assert line, f'{words[:3]} has ended with {started.wait()}'
        return started


def last_line(program: subprocess.Popen[str]) -> Any:
    """Return what a program prints at its end, read as JSON."""
    out, _ = program.communicate(timeout=300)
    return json.loads(out.splitlines()[-1])


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


def runs_of(executed: Path) -> Counter[str]:
    """Return how often each goal was begun so far, by the robots' file."""
    return Counter(executed.read_text(encoding='utf-8').split() if executed.exists() else ())


def measure(robots: int) -> None:
    """Measure a fleet, and print one paragraph."""
    with ExitStack() as stack:
        folder = Path(stack.enter_context(tempfile.TemporaryDirectory()))
        site = Site(folder, robots, stack)
        cloud, router = site.router('cloud'), site.router('site')
        started = time.monotonic()
        fleet_programs = site.serve()
        print(
            f'{robots} robots, up after {time.monotonic() - started:.1f} s; processor time: '
            f'{cpu_s(router):.1f} s of the site, {cpu_s(cloud):.1f} s of the cloud, '
            f'{sum(map(cpu_s, fleet_programs)):.1f} s of the robots',
            flush=True,
        )
        for title, pattern in (('robots=r0', ['r0']), ('everything', [])):
            took, seen, cpu = last_line(site.operate(OPERATOR, *pattern))
            print(f'  operator, {title}: {took:.3f} s to know r0, {seen} declarations, {cpu:.2f} s of CPU')
        before = cpu_s(cloud), cpu_s(router), cpu_s(fleet_programs[0])
        time.sleep(REST_S)
        after = cpu_s(cloud), cpu_s(router), cpu_s(fleet_programs[0])
        shares = [100 * (late - early) / REST_S for early, late in zip(before, after, strict=True)]
        print(f'  cloud: {memory_mb(cloud):.1f} MB, {shares[0]:.1f} % of a core at rest')
        print(f'  site: {memory_mb(router):.1f} MB, {shares[1]:.1f} % of a core at rest')
        here = min(robots, PER_PROCESS)
        print(
            f'  a robot: {ask_robot(fleet_programs[0])} tokens of others, '
            f'{memory_mb(fleet_programs[0]) / here:.1f} MB, {shares[2] / here:.2f} % of a core at rest',
            flush=True,
        )
        sender = site.operate(SENDER, str(robots), begins='sends')
        executed = folder / 'executed'
        ordered = cpu_s(sender), time.monotonic()
        while sender.poll() is None and sum(runs_of(executed).values()) < robots:
            time.sleep(0.1)
        print(
            f'  all robots drive {time.monotonic() - ordered[1]:.1f} s after the order, '
            f'{cpu_s(sender) - ordered[0]:.1f} s of which are processor time of the sender',
            flush=True,
        )
        router.kill()
        router.wait()
        time.sleep(1.0)
        site.router('site')
        ends = last_line(sender)
        times = dict(Counter(runs_of(executed).values()))
        print(f'  goals through the death of the site: {ends}; goals by how often they ran: {times}')


def main() -> None:
    """Measure fleets of some sizes."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument('--robots', default='1,10,100', help='numbers of robots')
    for number in map(int, parser.parse_args().robots.split(',')):
        measure(number)


if __name__ == '__main__':
    main()
