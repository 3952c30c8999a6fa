"""A simulated battery: motion drains it, and it charges while the robot rests."""

from __future__ import annotations

from humanoid.model import BATTERY, MOVING_SPEED, BatterySpec

SECONDS_PER_HOUR = 3600.0


class Battery:
    """Keeps the battery's charge, which changes only in `step` and `step_power`."""

    def __init__(self, fraction: float, spec: BatterySpec = BATTERY) -> None:
        """`fraction`: the charge at the start, as a part of the capacity from 0 to 1."""
        self.spec = spec
        self.charge = fraction * spec.capacity  # Ah
        self.current = -spec.idle_draw  # A, negative while discharging
        self._resting = 0.0  # s

    def step(self, elapsed: float, base_speed: float, joint_speed: float) -> None:
        """Let `elapsed` seconds pass; `base_speed` in m/s, `joint_speed` in rad/s, summed over all joints."""
        moving = base_speed > MOVING_SPEED or joint_speed > MOVING_SPEED
        self._pass(elapsed, self._draw(base_speed, joint_speed), moving=moving)

    def step_power(self, elapsed: float, power: float) -> None:
        """Let `elapsed` seconds pass in which the motors do `power` W of work, braking included."""
        draw = self.spec.idle_draw + power / self.voltage
        self._pass(elapsed, draw, moving=power > self.spec.idle_power)

    def _pass(self, elapsed: float, draw: float, *, moving: bool) -> None:
        self._resting = 0.0 if moving else self._resting + elapsed
        if self._resting >= self.spec.rest_before_charging:
            self.current = self.spec.charge_current if self.charge < self.spec.capacity else 0.0
        else:
            self.current = -draw
        charge = self.charge + self.current * elapsed / SECONDS_PER_HOUR
        self.charge = min(max(charge, 0.0), self.spec.capacity)

    def _draw(self, base_speed: float, joint_speed: float) -> float:
        spec = self.spec
        motion = spec.draw_per_base_speed * base_speed + spec.draw_per_joint_speed * joint_speed
        return spec.idle_draw + motion

    @property
    def percentage(self) -> float:
        """The charge as a part of the capacity, 0 to 1, as in sensor_msgs/BatteryState."""
        return self.charge / self.spec.capacity

    @property
    def voltage(self) -> float:
        """The voltage in V: it rises linearly with the charge, from empty to full."""
        spec = self.spec
        return spec.empty_voltage + (spec.full_voltage - spec.empty_voltage) * self.percentage

    @property
    def time_remaining(self) -> float:
        """Seconds until the battery is empty at the present current, or at the idle current if it charges."""
        draw = -self.current if self.current < 0.0 else self.spec.idle_draw
        return self.charge / draw * SECONDS_PER_HOUR
