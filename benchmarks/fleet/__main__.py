"""A simulated fleet: python -m benchmarks.fleet [--robots 1,10,100] [--sites 1] [--slow] [--kill site-0].
python -m benchmarks.fleet --robots 20 --sites 3 --slow --chaos MINUTES

Robots with the humanoid's names (or with a few of them, as `goalwire fleet join --allow` lets out: --names
few), each with a session and a certificate of its own, some in a process, dial the routers of their sites.
These dial a cloud, and an operator comes to the cloud, all with mutual TLS and the rules of
`goalwire fleet init`. With --slow each robot's and each site's link is a relay: 100 ms late, 10 Mbit/s,
with a stall of up to 5 s about each minute, and breaks about once an hour (--break-every).
Printed for each number of robots: the time until all are up; what the operator's session is sent and the time
until it knows one robot, with `robots=` and (but for --scoped) without; what one robot's session is sent;
memory and processor time of the routers at rest. At last goals are sent to all robots, once for each router
in --kill, and that router is killed (kill -9) and started again while all drive: how they ended, and how
often each was run.

With --chaos nothing of that is measured. Routers are killed and links are partitioned at random for so long,
while goals and calls go to all robots. A table and a list of problems come at the end.
"""

from __future__ import annotations

import argparse
import subprocess
import tempfile
import time
from collections import Counter
from collections.abc import Iterator, Sequence
from contextlib import ExitStack, contextmanager
from pathlib import Path

from benchmarks.fleet.chaos import go_through_chaos
from benchmarks.fleet.layout import Layout, ask_robot, cpu_s, last_line, memory_mb
from benchmarks.fleet.programs import OPERATOR, SENDER

REST_S = 10.0
IDLE = 0.2
"""The share of a core below which a router is done with the declarations of its robots."""
PATIENCE_S = 1200.0
QUICK = ('--delay-ms', '0', '--mbit', '1000', '--stall-every', '0')
SLOW = ('--delay-ms', '100', '--mbit', '10', '--stall-every', '60')


@contextmanager
def standing(robots: int, chosen: argparse.Namespace) -> Iterator[tuple[Layout, list[subprocess.Popen[str]]]]:
    """Bring a fleet up, say what that took, and end it after the block."""
    with ExitStack() as stack:
        folder = Path(stack.enter_context(tempfile.TemporaryDirectory()))
        slow = (*SLOW, '--break-every', str(chosen.break_every))
        links = slow if chosen.slow else QUICK if chosen.chaos else ()
        layout = Layout(folder, robots, chosen.names, chosen.sites, chosen.per_process, links, stack)
        layout.begin_routers()
        started = time.monotonic()
        programs = layout.serve()
        routers = ', '.join(f'{cpu_s(each):.1f} s of {name}' for name, each in layout.running.items())
        print(
            f'{robots} robots, up after {time.monotonic() - started:.1f} s; processor time: {routers}, '
            f'{sum(map(cpu_s, programs)):.1f} s of the robots',
            flush=True,
        )
        yield layout, programs


def await_quiet_routers(layout: Layout) -> None:
    """Wait until the routers have told each other of all robots, and print what that took."""
    started = time.monotonic()
    before = {name: cpu_s(each) for name, each in layout.running.items()}
    while time.monotonic() < started + PATIENCE_S:
        time.sleep(REST_S)
        now = {name: cpu_s(each) for name, each in layout.running.items()}
        if all(now[name] - before[name] < IDLE * REST_S for name in now):
            break
        before = now
    spent = ', '.join(f'{cpu_s(each):.1f} s of {name}' for name, each in layout.running.items())
    print(f'  routers quiet {time.monotonic() - started:.0f} s later: {spent}', flush=True)


def measure_attaching(layout: Layout, patterns: Sequence[str]) -> None:
    """Print how soon an operator knows one robot, for each pattern of robots that its session asks for."""
    for pattern in patterns:
        title = f'robots={pattern}' if pattern else 'everything'
        took, seen, cpu = last_line(layout.operate(OPERATOR, *filter(None, [pattern])))
        print(
            f'  operator, {title}: {took:.3f} s to know r0, {seen} declarations, {cpu:.2f} s of CPU',
            flush=True,
        )


def measure_rest(layout: Layout, programs: list[subprocess.Popen[str]]) -> None:
    """Print what routers and a robot take while nothing happens."""
    watched = {**layout.running, 'a robot': programs[0]}
    before = {name: cpu_s(each) for name, each in watched.items()}
    time.sleep(REST_S)
    share = {name: 100 * (cpu_s(each) - before[name]) / REST_S for name, each in watched.items()}
    for name, each in layout.running.items():
        print(f'  {name}: {memory_mb(each):.1f} MB, {share[name]:.1f} % of a core at rest')
    here = min(layout.robots, layout.per_process)
    print(
        f'  a robot: {ask_robot(programs[0])} tokens of others, {memory_mb(programs[0]) / here:.1f} MB, '
        f'{share["a robot"] / here:.2f} % of a core at rest',
        flush=True,
    )


def drive_through_a_death(layout: Layout, victim: str, drive_s: float) -> None:
    """Send a goal to each robot, kill a router while all drive, and print how the goals ended."""
    known = layout.runs()
    unsent = layout.folder / f'unsent-{victim}'
    unsent.touch()
    arguments = str(layout.robots), str(int(10 * drive_s)), str(unsent)
    sender = layout.operate(SENDER, *arguments, begins='sends')
    ordered = time.monotonic()
    before = spent = cpu_s(sender)
    driving = away = 0
    while driving + away < layout.robots and sender.poll() is None:
        spent = cpu_s(sender)
        time.sleep(0.1)
        driving = (layout.runs() - known).total()
        away = len(unsent.read_text(encoding='utf-8').split())
    spread = time.monotonic() - ordered
    print(
        f'  {driving} robots drive {spread:.1f} s after the order, each for {drive_s:.0f} s; '
        f'{spent - before:.1f} s of processor time of the sender',
        flush=True,
    )
    if spread > drive_s:
        print('  the first have arrived already: give them longer ways by --drive')
    layout.kill_router(victim)
    time.sleep(1.0)
    layout.begin_router(victim)
    ends = last_line(sender)
    times = dict(Counter((layout.runs() - known).values()))
    print(f'  goals through the death of {victim}: {ends}; goals by how often they ran: {times}', flush=True)
    if layout.relays:
        print(f'  links by now: {dict(layout.count_faults())}', flush=True)


def main() -> None:
    """Measure fleets of some sizes."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument('--robots', default='1,10,100', help='numbers of robots')
    parser.add_argument(
        '--names', choices=('all', 'few'), default='all', help='the names of the humanoid that a robot has'
    )
    parser.add_argument('--sites', type=int, default=1)
    parser.add_argument('--per-process', type=int, default=25, help='robots in one process')
    parser.add_argument(
        '--slow', action='store_true', help='links of 100 ms and 10 Mbit/s that stall and break'
    )
    parser.add_argument(
        '--break-every', type=float, default=3600.0, metavar='S', help='of each slow link; 0: never'
    )
    parser.add_argument(
        '--drive', type=float, metavar='S', help='how long each goal takes; default: 20 s and more'
    )
    parser.add_argument('--kill', default='site-0', help='the routers that die, such as cloud,site-0')
    parser.add_argument(
        '--scoped',
        action='store_true',
        help='no operator asks for all robots at once',
    )
    parser.add_argument('--chaos', type=float, default=0.0, metavar='MINUTES', help='kill and partition')
    chosen = parser.parse_args()
    problems = 0
    for number in map(int, chosen.robots.split(',')):
        with standing(number, chosen) as (layout, programs):
            if chosen.chaos:
                problems += go_through_chaos(layout, programs, chosen.chaos * 60)
                continue
            await_quiet_routers(layout)
            measure_attaching(layout, ['r0'] if chosen.scoped else ['r0', ''])
            measure_rest(layout, programs)
            for victim in chosen.kill.split(','):
                drive_through_a_death(layout, victim, chosen.drive or 20 + number / 10)
    raise SystemExit(1 if problems else 0)


if __name__ == '__main__':
    main()
