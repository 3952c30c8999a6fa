"""A mission recorded with its calls and goals is a regression test of the robot's servers."""

from __future__ import annotations

import shutil
import signal
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import pytest
from helpers.command_line import executable
from helpers.processes import Program
from helpers.robot import ROOT, humanoid, on_both_wires

pytestmark = [pytest.mark.slow, pytest.mark.long, pytest.mark.timeout(600)]

LONG = 200.0
UP = 'Ctrl-C stops them all'
MEANWHILE = (
    '--ignore-stamps',
    '--tolerance=0.3',  # m, rad, Ah: the machine does other things while the robot moves
    '--feedback-tolerance=5',
    '--exclude-services=/get_joint_state',  # the mission looks at joints that move
    '--answer-timeout=60',
    '--ignore-fields',
    'time_remaining',
    'current',  # it depends on what moved in the latest tick
    'power_supply_status',
    'message',  # it has the distance that was left
)
"""The fields that differ from one run to the next."""


@contextmanager
def robot_up(env: dict[str, str], *, is_forked: bool = True) -> Iterator[Program]:
    with humanoid('up', env=env, is_forked=is_forked) as up:
        up.expect(UP, LONG)
        yield up


def record_mission(bag: Path, env: dict[str, str]) -> None:
    with (
        robot_up(env),
        Program(
            executable(), 'bag', 'record', '--all-services', '--all-actions', '-o', str(bag), env=env
        ) as recorder,
    ):
        recorder.expect_each(
            *(f"recording '/{name}/_service_event'" for name in ('get_battery_status', 'get_joint_state')),
            *(
                f"recording '/{action}/_action/{part}/_service_event'"
                for action in ('move_arm', 'move_to_position')
                for part in ('send_goal', 'cancel_goal', 'get_result')
            ),
        )
        with humanoid('mission', env=env) as mission:
            mission.succeed(LONG)
        recorder.send_signal(signal.SIGINT)
        assert recorder.wait(LONG) == 0


def changed(folder: Path) -> Path:
    """The robot's package with one number changed: its battery holds 16 Ah, not 15."""
    copy = folder / 'humanoid'
    shutil.copytree(ROOT / 'robot' / 'humanoid', copy)
    model = copy / 'humanoid' / 'model.py'
    text = model.read_text()
    assert text.count('capacity: float = 15.0') == 1
    model.write_text(text.replace('capacity: float = 15.0', 'capacity: float = 16.0'))
    return copy


def expect(bag: Path, env: dict[str, str]) -> tuple[int, str]:
    """Send the mission's goals and requests to the robot that is up; the exit code, and what was told."""
    with Program(executable(), 'bag', 'play', str(bag), '--expect', *MEANWHILE, env=env) as play:
        code = play.wait(LONG)
        return code, play.output


@on_both_wires
def test_a_mission_is_repeated_and_one_number_that_was_changed_is_found(
    world: dict[str, str], tmp_path: Path
) -> None:
    bag = tmp_path / 'mission'
    record_mission(bag, world)
    with robot_up(world):
        code, told = expect(bag, world)
    assert 'everything is as it was recorded' in told
    assert code == 0
    with robot_up(world | {'PYTHONPATH': str(changed(tmp_path))}, is_forked=False):
        code, told = expect(bag, world)
    assert 'battery.design_capacity 16, was 15 (tolerance 0.3)' in told
    assert code == 1
