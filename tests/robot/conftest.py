from __future__ import annotations

import os
from collections.abc import Iterator
from typing import TYPE_CHECKING

import pytest
from helpers.robot import robot_client, robot_env

if TYPE_CHECKING:
    from humanoid.mission.robot import Robot


@pytest.fixture
def world(monkeypatch: pytest.MonkeyPatch) -> dict[str, str]:
    """The environment of a robot that nobody else can reach, for child processes and for this one."""
    env = robot_env()
    for name in set(os.environ) - set(env):
        monkeypatch.delenv(name)
    for name, value in env.items():
        monkeypatch.setenv(name, value)
    return env


@pytest.fixture
def robot(world: dict[str, str]) -> Iterator[Robot]:
    """A client of the robot in this process."""
    with robot_client() as client:
        yield client
