"""Exercise 1: the service tells how the battery is, in the units of sensor_msgs/BatteryState, and at once."""

from __future__ import annotations

import asyncio
import math
import re
from collections.abc import AsyncIterator
from pathlib import Path
from typing import TYPE_CHECKING

import goalwire
from goalwire.apps.course.bench import beside, wait_for_server
from goalwire.apps.course.student import Student, Wrong

if TYPE_CHECKING:
    from humanoid_interfaces.srv import GetBatteryStatus

SERVICE = 'get_battery_status'
ANSWERS_WITHIN = 2.0
PAUSE = 1.0
"""Seconds between two requests, enough for the simulated battery to lose a visible amount of charge."""
AT_ONCE = 10


async def steps(file: Path) -> AsyncIterator[str]:
    """Yield a sentence for each step that the program passes; raise Wrong at the first mistake."""
    from humanoid_interfaces.srv import GetBatteryStatus

    async with beside(file) as (node, student):
        client = node.client(GetBatteryStatus, SERVICE)
        await wait_for_server(
            node, student, client, 'service', SERVICE, 'humanoid_interfaces/srv/GetBatteryStatus'
        )
        yield f'it starts, and serves {SERVICE!r}'
        first = await _ask(student, client)
        yield 'it answers'
        _judge_battery(first)
        yield 'the battery has the units and signs of sensor_msgs/BatteryState'
        _judge_time(first)
        yield 'the time that remains fits charge and current'
        await asyncio.sleep(PAUSE)
        _judge_change(first, await _ask(student, client))
        yield 'each answer is measured anew'
        await asyncio.gather(*(_ask(student, client) for _ in range(AT_ONCE)))
        yield f'{AT_ONCE} clients at once get their answers'


async def _ask(
    student: Student, client: goalwire.Client[GetBatteryStatus.Request, GetBatteryStatus.Response]
) -> GetBatteryStatus.Response:
    try:
        return await student.during(client.call(timeout=ANSWERS_WITHIN), f'answer on {SERVICE!r}')
    except goalwire.DeadlineError:
        raise Wrong(
            f'no answer came within {ANSWERS_WITHIN:g} s',
            'a service callback has to return soon: it must not sleep or wait for something else',
        ) from None
    except goalwire.CallError as error:
        raise await _explain(student, error) from None


async def _explain(student: Student, error: goalwire.CallError) -> Wrong:
    """Return the mistake of a callback that failed."""
    failure = await student.failure()
    if failure is None:
        return Wrong(
            f'the callback failed, so the client got no answer: {error}',
            f'the end of what the program printed:\n{student.last_lines()}',
        )
    if 'the callback returned NoneType' in failure.text:
        return Wrong(
            'the callback failed, so the client got no answer: it returned None',
            '`return response` is missing at its end, or on one of its ways out',
        )
    if re.search(r'takes \d+ positional arguments? but \d+ were given', failure.text):
        return Wrong(
            f'the callback failed, so the client got no answer: {failure.text}',
            'a service callback gets the request and the response: def answer(self, request, response)',
        )
    return Wrong(
        f'the callback failed, so the client got no answer: {failure.text}',
        failure.advice or 'look where the callback sets the field that the message names',
    )


def _judge_battery(answer: GetBatteryStatus.Response) -> None:
    """Judge the fields in the order in which the task and the file list them."""
    battery = answer.battery
    if battery == type(battery)():
        raise Wrong(
            'the battery in the answer is empty',
            'set the fields of the battery (step 2), as state.voltage = …, and return the response that the '
            'callback got (step 3), not a new one',
        )
    if battery.header.stamp.sec == 0:
        raise Wrong(
            'battery.header.stamp is empty, so nobody knows how old the answer is',
            'self.get_clock().now().to_msg() is the time of the measurement',
        )
    for name in ('voltage', 'charge', 'capacity'):
        value = getattr(battery, name)
        if not value > 0.0:
            raise Wrong(f'battery.{name} is {value:g}', 'fill it in, in V or Ah: the class Battery knows it')
    if not battery.current < 0.0:
        raise Wrong(
            f'battery.current is {battery.current:g} A',
            'sensor_msgs/BatteryState wants it negative while the battery discharges',
        )
    if not 0.0 <= battery.percentage <= 1.0:
        raise Wrong(
            f'battery.percentage is {battery.percentage:g}',
            'it goes from 0 to 1, in spite of its name',
        )
    if not math.isclose(battery.percentage, battery.charge / battery.capacity, abs_tol=0.01):
        raise Wrong(
            f'battery.percentage is {battery.percentage:.2f}, but charge / capacity is '
            f'{battery.charge / battery.capacity:.2f}',
            'percentage is the part of the capacity that is left',
        )
    if battery.temperature == 0.0:
        raise Wrong(
            'battery.temperature says 0 degrees, and nothing measured that',
            "a value that nobody measures is NaN: float('nan')",
        )
    if battery.power_supply_status != battery.POWER_SUPPLY_STATUS_DISCHARGING:
        raise Wrong(
            f'battery.power_supply_status is {battery.power_supply_status}',
            'there is a constant: BatteryState.POWER_SUPPLY_STATUS_DISCHARGING',
        )
    if not battery.present:
        raise Wrong('battery.present is False', 'the robot has its battery: set it to True')


def _judge_time(answer: GetBatteryStatus.Response) -> None:
    remaining = answer.time_remaining.sec
    expected = answer.battery.charge / -answer.battery.current * 3600.0
    if not math.isclose(remaining, expected, rel_tol=0.02):
        raise Wrong(
            f'time_remaining is {remaining} s, but charge / current says {expected:.0f} s',
            'charge is in Ah and current in A, so their quotient is in hours; time_remaining.sec is an int',
        )


def _judge_change(first: GetBatteryStatus.Response, second: GetBatteryStatus.Response) -> None:
    if not second.battery.charge < first.battery.charge:
        raise Wrong(
            f'the charge is still the same after {PAUSE:g} s',
            'measure in the callback, not once in __init__',
        )
    if second.battery.header.stamp == first.battery.header.stamp:
        raise Wrong('the stamp is the same in two answers', 'take the time in the callback')
