"""`humanoid demo`: the servers and the mission as processes, shown live and summed up in a table."""

from __future__ import annotations

import time
from collections.abc import Sequence
from pathlib import Path

from humanoid import view as console
from humanoid.domain import claim_domain
from humanoid.fleet import fleet
from humanoid.mission.display import display
from humanoid.mission.events import Retrying, Sink, from_line
from humanoid.mission.summary import Summary
from humanoid.physics.choice import describe_choice, uses_physics
from humanoid.servers import servers
from humanoid.supervisor import Ended, Printed, StopAsked, Supervisor, program
from humanoid.up import SIM_TIME
from humanoid.world.names import HOUSE, choose

MISSION = 'mission'
LATE = 'battery_service'  # started only after the mission has called it in vain
FOR_VIEWERS = 'robot_state_publisher'  # the mission does not need this program: without a page it starts last
WITHOUT_PAGE = 'the demo goes on without the page'
PAGE_WITHIN = 30.0  # s to wait for the page; then the mission begins without it
TIME_LIMIT = 400.0  # s: a mission takes 15 s; 70 s with physics and its extra steps, and most in the house


class Failed(Exception):
    """The demo cannot go on; the text says why and names the program."""


def demo(
    *, physics: bool | None = None, sim_time: bool = False, view: bool = False, world: str | None = None
) -> int:
    """Run the demo; return 0 only if every step succeeded and no program ended early.

    `physics` as in humanoid.physics.choice, `view`: with the page in the browser, which is served before the
    mission begins, `world`: a name or a file. Raises Taken, NotInstalled, BadWorld and NoView.
    """
    summary = Summary()
    problem = None
    physics = uses_physics(physics)
    arguments = SIM_TIME if sim_time else ()
    [robot] = fleet([], choose(world))
    page = console.command() if view else None
    with claim_domain(may_move=True), Supervisor() as supervisor:
        print(describe_choice(physics=physics), flush=True)
        if page is not None:
            supervisor.start(console.NAME, page)
        later = (LATE, FOR_VIEWERS) if page is None else (LATE,)
        for name in servers(physics=physics, world=world is not None):
            if name not in later:
                _start(supervisor, name, *robot.arguments(name, Path()), *arguments)
        try:
            if page is not None:
                _await_page(supervisor)
            body = ('--whole-body',) if physics else ()
            house = ('--in-house',) if world == HOUSE else ()
            _start(supervisor, MISSION, '--events', '--battery-starts-late', *body, *house, *arguments)
            with display() as show:
                _follow(supervisor, summary, show, [(name, *arguments) for name in later])
        except Failed as failure:
            problem = str(failure)
            supervisor.stop(MISSION)  # before the servers, so that they can cancel its goals
    if summary.begun:
        print(summary.table())
    if problem is None and not summary.all_well:
        problem = 'not every step ended as it should'
    if problem is not None:
        print(f'demo failed: {problem}')
    return 1 if problem else 0


def _start(supervisor: Supervisor, name: str, *arguments: str) -> None:
    pid = supervisor.start(name, program(name, *arguments))
    print(f'started {name} (pid {pid})', flush=True)


def _await_page(supervisor: Supervisor) -> None:
    """Wait until the page is served or has failed, so that a viewer sees the whole mission. Raises Failed."""
    deadline = time.monotonic() + PAGE_WITHIN
    while True:
        event = supervisor.next_event(deadline)
        if event is None:
            print(f'the page was not served within {PAGE_WITHIN:.0f} s; {WITHOUT_PAGE}', flush=True)
            return
        if isinstance(event, StopAsked):
            raise Failed('stopped on request')
        if event.name == console.NAME:
            _relay(event)
            if isinstance(event, Ended) or console.is_served(event.line):
                return
        elif isinstance(event, Ended):
            raise _cut_short(supervisor, event)


def _relay(event: Printed | Ended) -> None:
    """Print a line of output of the page's program, or how that program ended."""
    print(event.line if isinstance(event, Printed) else f'{event}; {WITHOUT_PAGE}', flush=True)


def _follow(supervisor: Supervisor, summary: Summary, show: Sink, later: Sequence[Sequence[str]]) -> None:
    """Follow the mission to its end; start the programs in `later` when a step is retried. Raises Failed."""
    deadline = time.monotonic() + TIME_LIMIT
    while True:
        event = supervisor.next_event(deadline)
        if event is None:
            raise Failed(f'the mission did not end within {TIME_LIMIT:.0f} s')
        if isinstance(event, StopAsked):
            raise Failed('stopped on request')
        if event.name == console.NAME:
            _relay(event)
            continue
        if isinstance(event, Ended):
            _judge_end(supervisor, summary, event)
            return
        told = from_line(event.line) if event.name == MISSION else None
        if told is not None:
            summary.note(told)
            show(told)
            if isinstance(told, Retrying):
                for command in later:
                    _start(supervisor, *command)
                later = ()


def _judge_end(supervisor: Supervisor, summary: Summary, ended: Ended) -> None:
    """Raise Failed if a program ended before the mission was complete."""
    if ended.name == MISSION:
        # If the mission failed because a server ended, the event of that end may be next in the queue.
        while event := supervisor.next_event(time.monotonic()):
            if isinstance(event, Ended) and event.name != console.NAME:
                ended = event
                break
    if ended.name != MISSION or not summary.complete:
        raise _cut_short(supervisor, ended)


def _cut_short(supervisor: Supervisor, ended: Ended) -> Failed:
    last = ''.join(f'\n    {line}' for line in supervisor.tail(ended.name) if from_line(line) is None)
    return Failed(f'{ended} in mid-demo; its last lines:{last or " none"}')
