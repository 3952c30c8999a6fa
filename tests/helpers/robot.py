"""The humanoid's programs as processes, and a node that talks to them."""

from __future__ import annotations

import os
import select
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING

import pytest
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


def humanoid(*arguments: str, env: Mapping[str, str]) -> Program:
    """Run `humanoid ARGUMENTS`."""
    return Program(_MAIN, *arguments, env=env)


def course(name: str, *, env: Mapping[str, str]) -> Program:
    """Run one of the chapter's programs."""
    return Program(COURSE / f'{name}.py', env=env)


@contextmanager
def robot_client() -> Iterator[Robot]:
    """A client of the robot in this process, whose environment says where it is."""
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
