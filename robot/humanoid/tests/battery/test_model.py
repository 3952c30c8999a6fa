from __future__ import annotations

import pytest

from humanoid.battery.model import Battery
from humanoid.model import BATTERY, BatterySpec

TINY = BatterySpec(capacity=0.01)


def test_motion_drains_more_than_standing() -> None:
    standing, driving, waving = Battery(0.8), Battery(0.8), Battery(0.8)
    standing.step(1.0, 0.0, 0.0)
    driving.step(1.0, 0.8, 0.0)
    waving.step(1.0, 0.0, 2.0)
    assert standing.charge > waving.charge > driving.charge


def test_charge_counts_current_over_time() -> None:
    battery = Battery(0.5)
    before = battery.charge
    battery.step(36.0, 1.0, 0.0)
    assert battery.current == -(BATTERY.idle_draw + BATTERY.draw_per_base_speed)
    assert before - battery.charge == pytest.approx(-battery.current * 0.01)


def test_it_charges_once_it_has_rested_long_enough() -> None:
    battery = Battery(0.5)
    battery.step(BATTERY.rest_before_charging / 2, 0.0, 0.0)
    assert battery.current < 0.0
    battery.step(BATTERY.rest_before_charging / 2, 0.0, 0.0)
    assert battery.current == BATTERY.charge_current
    before = battery.charge
    battery.step(1.0, 0.0, 0.0)
    assert battery.charge > before


def test_motion_ends_the_charging_at_once() -> None:
    battery = Battery(0.5)
    battery.step(60.0, 0.0, 0.0)
    battery.step(0.1, 0.5, 0.0)
    assert battery.current < 0.0
    battery.step(0.1, 0.0, 0.0)
    assert battery.current < 0.0


def test_a_full_battery_takes_no_more() -> None:
    battery = Battery(0.999, TINY)
    battery.step(60.0, 0.0, 0.0)
    battery.step(60.0, 0.0, 0.0)
    assert (battery.percentage, battery.current) == (1.0, 0.0)
    assert battery.voltage == TINY.full_voltage


def test_an_empty_battery_gives_no_more() -> None:
    battery = Battery(0.01, TINY)
    battery.step(600.0, 1.0, 0.0)
    assert (battery.charge, battery.percentage, battery.time_remaining) == (0.0, 0.0, 0.0)
    assert battery.voltage == TINY.empty_voltage


def test_the_time_remaining_is_how_long_the_present_draw_can_last() -> None:
    battery = Battery(0.5)
    battery.step(1.0, 0.4, 0.0)
    remaining = battery.time_remaining
    battery.step(remaining, 0.4, 0.0)
    assert battery.charge == pytest.approx(0.0, abs=1e-9)


def test_while_charging_the_time_remaining_counts_the_idle_draw() -> None:
    battery = Battery(0.5)
    battery.step(60.0, 0.0, 0.0)
    assert battery.current > 0.0
    assert battery.time_remaining == pytest.approx(battery.charge / BATTERY.idle_draw * 3600.0)


def test_work_of_the_motors_drains_beside_the_idle_draw() -> None:
    battery = Battery(0.5)
    volts = battery.voltage
    battery.step_power(1.0, 200.0)
    assert battery.current == pytest.approx(-(BATTERY.idle_draw + 200.0 / volts))


def test_motors_that_do_not_work_let_it_charge() -> None:
    battery = Battery(0.5)
    battery.step_power(BATTERY.rest_before_charging, 0.0)
    assert battery.current == BATTERY.charge_current
    battery.step_power(0.1, 50.0)
    assert battery.current < 0.0
