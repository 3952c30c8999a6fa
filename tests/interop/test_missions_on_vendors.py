"""A mission on an action server of the real rclpy: its runner is killed, and no goal runs twice."""

from __future__ import annotations

import os
import time
from collections import Counter
from collections.abc import Callable
from contextlib import ExitStack
from pathlib import Path

import pytest
from helpers import real_rclpy
from helpers.chance import fresh_chance
from helpers.environments import Environment
from helpers.isolation import isolated_env
from helpers.processes import Program
from helpers.wires import DDS

from goalwire.transport.dds import CHOICE, NATIVE

PROGRAMS = Path(__file__).parent / 'programs'
KILLS = int(os.environ.get('GOALWIRE_TEST_MISSION_KILLS', '5'))
PLACES = 2 * KILLS
FAST_DDS = 'rmw_fastrtps_cpp'
IN_TIME = 120.0


@pytest.mark.long
@pytest.mark.timeout(3600)
def test_no_goal_runs_twice_at_a_server_of_the_real_rclpy(
    install: Callable[..., Environment], tmp_path: Path, record_property: Callable[[str, object], None]
) -> None:
    if not real_rclpy.EXISTS:
        pytest.skip(real_rclpy.WHY_NOT)
    python = install(*real_rclpy.KILTED).python
    world = isolated_env(DDS) | {'RMW_IMPLEMENTATION': FAST_DDS}
    ours = world | {CHOICE: NATIVE, 'AMENT_PREFIX_PATH': str(python.parents[1])}
    executions = tmp_path / 'executions.txt'
    mission = f'{PROGRAMS / "vendor_rounds.py"}:rounds'
    arguments = ('mission', 'run', '-j', str(tmp_path / 'm.db'), '--id', 'm', mission, str(PLACES))
    chance = fresh_chance(record_property)
    with ExitStack() as stack:
        drives = Program(PROGRAMS / 'vendor_drives.py', str(executions), env=world, python=python)
        stack.enter_context(drives).expect('^ready$')

        def start() -> Program:
            return stack.enter_context(Program(Path('-m'), 'goalwire', *arguments, env=ours))

        runner, kills, last_step = start(), 0, 0
        while kills < KILLS:
            found = runner.expect(
                r'step (\d+): goal drive begins|asks: |^Mission succeeded|^goalwire: ', IN_TIME
            )
            assert 'begins' in found[0], runner.output
            if int(found[1] or 0) <= last_step and chance.random() < 0.9:
                continue  # a runner first repeats what its mission has done
            last_step = max(last_step, int(found[1] or 0))
            time.sleep(chance.random())  # any moment will do
            runner.kill()
            runner.wait()
            runner, kills = start(), kills + 1
        assert 'succeeded' in runner.expect('asks: |^Mission succeeded|^goalwire: ', 5 * IN_TIME)[0]
    record_property('kills', kills)
    begun = Counter(
        line.split()[0] for line in executions.read_text(encoding='utf-8').splitlines() if 'begun' in line
    )
    assert len(begun) == PLACES
    assert set(begun.values()) == {1}
