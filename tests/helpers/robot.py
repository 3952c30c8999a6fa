"""The humanoid's programs as processes, and a node that talks to them."""

from __future__ import annotations

import atexit
import os
import select
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from functools import cache
from importlib.util import find_spec
from pathlib import Path
from typing import TYPE_CHECKING

import pytest
from helpers.forking import ForkServer
from helpers.isolation import NETWORK, isolated_env
from helpers.processes import Program
from helpers.wires import DDS

if TYPE_CHECKING:
    from humanoid.mission.robot import Robot

ROOT = Path(__file__).resolve().parents[2]
COURSE = ROOT / 'examples' / 'course'

_MAIN = 'from humanoid.cli import main; raise SystemExit(main())'


on_both_wires = pytest.mark.parametrize('network', ['rmw_zenoh_cpp', DDS])


def robot_env(network: str = NETWORK) -> dict[str, str]:
    """An isolated world in which the robot's package and its interfaces are found."""
    return isolated_env(network) | {
        'PYTHONPATH': str(ROOT / 'robot' / 'humanoid'),
        'GOALWIRE_INTERFACE_PATH': str(ROOT / 'robot'),
        'HUMANOID_PHYSICS': '0',  # tests of the physics ask for it
    }


_FORKED = """
from helpers import robot_children
from humanoid.cli import main
robot_children.fork_them()
raise SystemExit(main())
"""
"""The same, and what `humanoid up` and `humanoid demo` start is forked, too."""

_PRELOADED = (
    'helpers.robot_children',
    'humanoid.demo',
    'humanoid.operate',
    'humanoid.up',
    'humanoid.joints.service',
    'humanoid.navigation.server',
    'humanoid.battery.service',
    'humanoid.arm.server',
    'humanoid.robot_state_publisher',
    'humanoid.world.server',
    'humanoid.localisation.server',
    'humanoid.route.server',
    'humanoid.mission.program',
)
_OF_PHYSICS = 'humanoid.physics.program'


@cache
def server_of_robots(site: Path | None) -> ForkServer:
    """The process that forks the robot's programs, for all tests of this process.

    They share nothing but imported modules, which take a program most of a second of a core otherwise.
    `site`: where the robot is installed, if not in the checkout.
    """
    env = robot_env()
    if site:
        del env['GOALWIRE_INTERFACE_PATH']
    env['PYTHONPATH'] = os.pathsep.join([str(site or env['PYTHONPATH']), str(ROOT / 'tests')])
    physics = [_OF_PHYSICS] if find_spec('mujoco') and find_spec('daqp') else []
    server = ForkServer([*_PRELOADED, *physics], env)
    atexit.register(server.close)
    return server


def humanoid(
    *arguments: str,
    env: Mapping[str, str],
    cwd: Path | None = None,
    site: Path | None = None,
    is_forked: bool = True,
) -> Program:
    """Run `humanoid ARGUMENTS`, of the checkout or as it is installed in `site`.

    `is_forked`: forked from a process that has imported the robot; if not, `PYTHONPATH` may name another one.
    """
    if os.name != 'posix' or not is_forked:
        return Program(_MAIN, *arguments, env=env, cwd=cwd)
    return Program(_FORKED, *arguments, env=env, cwd=cwd, server=server_of_robots(site))


def course(name: str, *, env: Mapping[str, str]) -> Program:
    """Run one of the chapter's programs."""
    return Program(COURSE / f'{name}.py', env=env, server=server_of_robots(None))


@contextmanager
def robot_client() -> Iterator[Robot]:
    """A client of the robot, in this process, whose environment says where the robot is."""
    import rclpy
    from humanoid.mission.robot import Robot

    rclpy.init(args=[])
    try:
        with Robot() as robot:
            yield robot
    finally:
        rclpy.shutdown()


def wait_until_gone(pid: int, timeout: float) -> bool:
    """Wait for the end of a process that need not be a child of this one (Linux); True once it has ended."""
    try:
        descriptor = os.pidfd_open(pid)
    except ProcessLookupError:
        return True
    try:
        poll = select.poll()
        poll.register(descriptor, select.POLLIN)
        return bool(poll.poll(timeout * 1000))
    finally:
        os.close(descriptor)
