"""battery_service: publishes `battery_state` and answers `get_battery_status`, for a simulated battery.

The battery's drain follows from `motor_power`, or without that from `odom` and `joint_states`.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

from diagnostic_msgs.msg import DiagnosticStatus
from humanoid_interfaces.srv import GetBatteryStatus
from nav_msgs.msg import Odometry
from rclpy.node import Node
from sensor_msgs.msg import BatteryState, JointState
from std_msgs.msg import Float64

from humanoid.battery.model import Battery
from humanoid.clock import duration_msg, now, stamp
from humanoid.diagnostics import Diagnostics, Health
from humanoid.model import GREATEST_SPEED
from humanoid.running import run

TICK = 0.1  # s between battery steps
TELL_EVERY = 1.0  # s
LOW, EMPTY = 0.2, 0.05  # shares of the capacity: below LOW diagnostics report WARN, below EMPTY ERROR
STALE_AFTER = 0.5  # s: a speed or power received longer ago is ignored
GREATEST_POWER = 100_000.0  # W: a message with more power is taken as wrong, and ignored
MOST_TOLD = 1000  # motor_power messages kept between two ticks at most
FIRST_CHARGE = 0.8  # of the capacity


class Seen:
    """The last speed received, and the time of receipt. Impossible speeds (NaN, 1e300) are ignored."""

    def __init__(self) -> None:
        self._speed = 0.0
        self._at = -math.inf

    def note(self, speed: float, at: float) -> None:
        if speed <= GREATEST_SPEED:
            self._speed, self._at = speed, at

    def speed(self, at: float) -> float:
        return self._speed if at - self._at <= STALE_AFTER else 0.0


class Power:
    """The power that the motors report, in W. Impossible values (NaN, -1, 1e300) are ignored."""

    def __init__(self) -> None:
        self._told: list[float] = []
        self._last, self._at = 0.0, -math.inf

    def note(self, power: float, at: float) -> None:
        if 0.0 <= power <= GREATEST_POWER and len(self._told) < MOST_TOLD:
            self._told.append(power)
            self._at = at

    def mean(self, at: float) -> float | None:
        """Return the mean power reported since the last call, or None if no report has come lately."""
        if at - self._at > STALE_AFTER:
            self._told.clear()
            return None
        if self._told:
            self._last = sum(self._told) / len(self._told)
            self._told.clear()
        return self._last


class BatteryService(Node):
    """Drains the simulated battery by the robot's measured motion, and charges it at rest."""

    def __init__(self) -> None:
        super().__init__('battery_service')
        self._battery = Battery(FIRST_CHARGE)
        self._base = Seen()
        self._joints = Seen()
        self._power = Power()
        self._stepped = now(self)
        self.create_subscription(Odometry, 'odom', self._see_base, 10)
        self.create_subscription(JointState, 'joint_states', self._see_joints, 10)
        self._states = self.create_publisher(BatteryState, 'battery_state', 10)
        self._diagnostics = Diagnostics(self, 'battery', self._health)
        self.create_subscription(Float64, 'motor_power', self._see_power, 10)
        self.create_timer(TICK, self._tick)
        self.create_timer(TELL_EVERY, lambda: self._states.publish(self._state()))
        self.create_service(GetBatteryStatus, 'get_battery_status', self._answer)
        self.get_logger().info('Battery Service ready')

    def _see_base(self, odometry: Odometry) -> None:
        velocity = odometry.twist.twist.linear
        self._base.note(math.hypot(velocity.x, velocity.y), now(self))

    def _see_joints(self, states: JointState) -> None:
        self._joints.note(sum(abs(velocity) for velocity in states.velocity), now(self))

    def _see_power(self, power: Float64) -> None:
        self._power.note(power.data, now(self))

    def _tick(self) -> None:
        moment = now(self)
        elapsed, self._stepped = max(moment - self._stepped, 0.0), moment
        power = self._power.mean(moment)
        if power is not None:
            self._battery.step_power(elapsed, power)
        else:
            self._battery.step(elapsed, self._base.speed(moment), self._joints.speed(moment))

    def _answer(
        self, _request: GetBatteryStatus.Request, response: GetBatteryStatus.Response
    ) -> GetBatteryStatus.Response:
        response.battery = self._state()
        response.time_remaining = duration_msg(self._battery.time_remaining)
        return response

    def _health(self) -> Health:
        battery = self._battery
        level = DiagnosticStatus.OK
        if battery.percentage < LOW:
            level = DiagnosticStatus.ERROR if battery.percentage < EMPTY else DiagnosticStatus.WARN
        values = {'voltage': f'{battery.voltage:.2f}', 'current': f'{battery.current:.2f}'}
        return Health(f'{battery.percentage:.0%}', level, values)

    def _state(self) -> BatteryState:
        battery, state = self._battery, BatteryState()
        state.header.stamp = stamp(self)
        state.voltage = battery.voltage
        state.temperature = math.nan  # not measured
        state.current = battery.current
        state.charge = battery.charge
        state.capacity = state.design_capacity = battery.spec.capacity
        state.percentage = battery.percentage
        if battery.current > 0.0:
            state.power_supply_status = BatteryState.POWER_SUPPLY_STATUS_CHARGING
        elif battery.current < 0.0:
            state.power_supply_status = BatteryState.POWER_SUPPLY_STATUS_DISCHARGING
        else:
            state.power_supply_status = BatteryState.POWER_SUPPLY_STATUS_FULL
        state.power_supply_health = BatteryState.POWER_SUPPLY_HEALTH_GOOD
        state.power_supply_technology = BatteryState.POWER_SUPPLY_TECHNOLOGY_LION
        state.present = True
        state.location = 'torso'
        return state


def main(args: Sequence[str] | None = None) -> int:
    return run(BatteryService, args)


if __name__ == '__main__':
    raise SystemExit(main())
