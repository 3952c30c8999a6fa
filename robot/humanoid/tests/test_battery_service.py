"""battery_service beside the base that it watches, each its own process."""

from __future__ import annotations

import math
import time

import pytest
from helpers.robot import humanoid
from sensor_msgs.msg import BatteryState
from std_msgs.msg import Float64

from humanoid.mission.robot import Robot
from humanoid.model import BATTERY

pytestmark = pytest.mark.slow


def test_the_state_follows_the_definition_of_battery_state(world: dict[str, str], robot: Robot) -> None:
    with humanoid('battery_service', env=world):
        status = robot.battery(timeout=10.0)
    battery = status.battery
    assert battery.percentage == pytest.approx(battery.charge / battery.capacity)
    assert 0.79 < battery.percentage < 0.801
    assert BATTERY.empty_voltage < battery.voltage < BATTERY.full_voltage
    assert battery.current == -BATTERY.idle_draw
    assert battery.power_supply_status == BatteryState.POWER_SUPPLY_STATUS_DISCHARGING
    assert battery.present
    assert math.isnan(battery.temperature)
    assert status.time_remaining.sec == pytest.approx(battery.charge / BATTERY.idle_draw * 3600, rel=0.01)


def test_driving_drains_it_and_rest_charges_it(world: dict[str, str], robot: Robot) -> None:
    with (
        humanoid('battery_service', env=world) as battery,
        humanoid('navigation_action_server', env=world),
    ):
        battery.expect('Battery Service ready')
        with robot.drive(0.8, 0.0, allowed=10.0, timeout=15.0) as run:
            draws = [robot.battery().battery.current for _ in run.feedback()]
        assert run.status == 'SUCCEEDED'
        assert min(draws) < -BATTERY.idle_draw - BATTERY.draw_per_base_speed * 0.5
        status = robot.battery()
        while status.battery.current < 0.0:  # bounded by the test's time limit; each call is a round trip
            low, status = status.battery.charge, robot.battery()
    assert status.battery.power_supply_status == BatteryState.POWER_SUPPLY_STATUS_CHARGING
    assert status.battery.charge >= low


def test_it_pays_for_the_work_that_the_motors_tell(world: dict[str, str], robot: Robot) -> None:
    told = robot.node.create_publisher(Float64, 'motor_power', 10)
    with humanoid('battery_service', env=world):
        robot.battery(timeout=15.0)
        deadline = time.monotonic() + 30.0
        state = robot.battery().battery
        while state.current > -(BATTERY.idle_draw + 9.0):
            assert time.monotonic() < deadline, state
            for power in (500.0, math.nan, -7e9, 1e300):  # only the first is a power
                told.publish(Float64(data=power))
            state = robot.battery().battery
        assert state.current == pytest.approx(-(BATTERY.idle_draw + 500.0 / state.voltage), rel=0.01)
