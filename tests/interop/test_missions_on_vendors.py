"""A mission on an action server of the real rclpy: runner and server are killed, and no goal runs twice.

A tap notes each goal on the wire if this process may read the packets of the loopback interface.
"""

from __future__ import annotations

import os
from collections.abc import Callable
from contextlib import ExitStack
from pathlib import Path

import pytest
from helpers import real_rclpy
from helpers.chance import fresh_chance
from helpers.environments import Environment
from helpers.isolation import isolated_env
from helpers.killed_missions import (
    World,
    assert_each_was_executed_once,
    assert_none_was_sent_to_a_server_that_knew_it,
    may_read_packets,
    ports_of,
)
from helpers.processes import Program
from helpers.wires import DDS

from goalwire.transport.dds import CHOICE, NATIVE

PROGRAMS = Path(__file__).parent / 'programs'
TAP = Path(__file__).parents[1] / 'missions' / 'programs' / 'tap_dds.py'
KILLS = int(os.environ.get('GOALWIRE_TEST_MISSION_KILLS', '5'))
FAST_DDS = 'rmw_fastrtps_cpp'


@pytest.mark.long
@pytest.mark.timeout(7200)
@pytest.mark.parametrize('victims', ['client', 'server', 'both'])
def test_no_goal_runs_twice_at_a_server_of_the_real_rclpy(
    victims: str,
    install: Callable[..., Environment],
    tmp_path: Path,
    record_property: Callable[[str, object], None],
) -> None:
    if not real_rclpy.EXISTS:
        pytest.skip(real_rclpy.WHY_NOT)
    python = install(*real_rclpy.KILTED).python
    env = isolated_env(DDS) | {'RMW_IMPLEMENTATION': FAST_DDS}
    chance = fresh_chance(record_property)

    def start_base(executions: Path) -> Program:
        return Program(PROGRAMS / 'vendor_drives.py', str(executions), env=env, python=python)

    with ExitStack() as stack:
        heard = tmp_path / 'heard.txt' if may_read_packets() else None
        if heard is not None:
            stack.enter_context(Program(TAP, str(heard), *ports_of(env['ROS_DOMAIN_ID']), env=env)).expect(
                '^ready$'
            )
        world = World(
            tmp_path,
            stack,
            start_base=start_base,
            mission=PROGRAMS / 'vendor_rounds.py',
            places=2 * KILLS,
            env=env | {CHOICE: NATIVE, 'AMENT_PREFIX_PATH': str(python.parents[1])},
            heard=heard,
        )
        world.kill_often(victims, KILLS, chance)
    record_property('kills', world.kills)
    record_property('questions', world.questions())
    record_property('tapped', world.heard is not None)
    assert_each_was_executed_once(world)
    if world.heard is not None:
        assert_none_was_sent_to_a_server_that_knew_it(world)
    assert victims != 'client' or world.questions() == 0
