from __future__ import annotations

import os
from collections.abc import Iterator
from typing import TYPE_CHECKING

import pytest
from helpers.isolation import NETWORK
from helpers.robot import robot_client, robot_env
from helpers.wires import require

if TYPE_CHECKING:
    from humanoid.mission.robot import Robot


@pytest.fixture
def network() -> str:
    """The network that the world is on; tests marked `helpers.robot.on_both_wires` run on each."""
    return NETWORK


@pytest.fixture
def world(monkeypatch: pytest.MonkeyPatch, network: str) -> dict[str, str]:
    """The environment of a robot that nobody else can reach, for child processes and for this one."""
    require(network)
    env = robot_env(network)
    for name in set(os.environ) - set(env):
        monkeypatch.delenv(name)
    for name, value in env.items():
        monkeypatch.setenv(name, value)
    return env


@pytest.fixture(scope='module')
def shared_world() -> Iterator[dict[str, str]]:
    """A world of its own for the tests of a module, which share the programs that they start in it."""
    with pytest.MonkeyPatch.context() as patch:
        wanted = robot_env()
        for name in set(os.environ) - set(wanted):
            patch.delenv(name)
        for name, value in wanted.items():
            patch.setenv(name, value)
        yield wanted


@pytest.fixture
def robot(world: dict[str, str]) -> Iterator[Robot]:
    """A client of the robot in this process."""
    with robot_client() as client:
        yield client
