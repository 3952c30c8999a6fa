"""The robot's mission in the asyncio API, against the robot's own servers; and how much shorter it is."""

from __future__ import annotations

from pathlib import Path

import pytest
from helpers.processes import Program
from helpers.robot import ROOT, humanoid, robot_env

MISSION = ROOT / 'examples' / 'asyncio' / 'mission.py'
WITH_RCLPY = ROOT / 'robot' / 'humanoid' / 'humanoid' / 'mission'


def lines(*files: Path) -> int:
    return sum(len(file.read_text().splitlines()) for file in files)


@pytest.mark.slow
def test_every_step_ends_as_expected() -> None:
    env = robot_env()
    with humanoid('up', env=env), Program(MISSION, env=env) as mission:
        output = mission.succeed(timeout=90.0)
    assert [line.split(':')[0] for line in output.splitlines()] == [
        'ok      battery',
        'ok      ask every joint',
        'ok      raise the left arm',
        'ok      arm beyond its limits',
        'ok      drive to (1.2, 0.9)',
        'ok      drive, cancel half-way',
        'ok      drive below the floor',
        'ok      newer goal while driving',
        'ok      drive with too little time',
        'ok      home, lowering the arm',
    ]


def test_it_takes_half_the_lines_of_the_same_steps_with_rclpy() -> None:
    """Without what the other one has besides: a moving display, events for a supervisor, a summary."""
    parts = [WITH_RCLPY / f'{name}.py' for name in ('calls', 'retry', 'robot', 'steps')]
    assert 2 * lines(MISSION) <= lines(*parts)
