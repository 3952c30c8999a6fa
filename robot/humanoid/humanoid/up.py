"""`humanoid up`: every server as its own process, until Ctrl-C."""

from __future__ import annotations

import tempfile
from collections.abc import Sequence
from pathlib import Path

from humanoid import view as console
from humanoid.domain import claim_domain
from humanoid.fleet import fleet
from humanoid.physics.choice import describe_choice, uses_physics
from humanoid.servers import servers
from humanoid.supervisor import Ended, Printed, StopAsked, Supervisor, program
from humanoid.world.names import choose

SIM_TIME = ('--ros-args', '-p', 'use_sim_time:=true')


def up(
    *,
    physics: bool | None = None,
    sim_time: bool = False,
    names: Sequence[str] = (),
    view: bool = False,
    world: str | None = None,
    params_file: Path | None = None,
) -> int:
    """Run the servers and print their output. If one ends by itself, the others go on; the result is then 1.

    `physics` as in humanoid.physics.choice, `names` as in humanoid.fleet: a robot for each, `view`: with the
    page in the browser, `world`: a name or a file, `params_file`: parameters for all programs. Raises Taken,
    NotInstalled, BadName, BadWorld and NoView.
    """
    died = started = 0
    robots = fleet(names, choose(world))
    physics = uses_physics(physics)
    more = [] if params_file is None else ['--ros-args', '--params-file', str(params_file)]
    more += SIM_TIME if sim_time else ()
    page = console.command() if view else None
    with (
        claim_domain(may_move=False),
        tempfile.TemporaryDirectory(prefix='humanoid_') as folder,
        Supervisor() as supervisor,
    ):
        print(describe_choice(physics=physics), flush=True)
        for robot in robots:
            for name in servers(physics=physics, world=world is not None):
                label = robot.label(name)
                command = program(name, *robot.arguments(name, Path(folder)), *more)
                print(f'started {label} (pid {supervisor.start(label, command)})', flush=True)
                started += 1
        if page is not None:
            supervisor.start(console.NAME, page)
        print('Ctrl-C stops them all', flush=True)
        while died < started:
            event = supervisor.next_event()
            if isinstance(event, Printed):
                print(f'[{event.name}] {event.line}', flush=True)
            elif isinstance(event, Ended):
                died += event.name != console.NAME
                print(f'{event}; the others go on', flush=True)
            elif isinstance(event, StopAsked):
                print('stopping', flush=True)
                break
    return 1 if died else 0
