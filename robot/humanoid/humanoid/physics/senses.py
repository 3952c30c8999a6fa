"""The body's sensors for its walker: the simulation's values with noise and delay added."""

from __future__ import annotations

from collections import deque
from dataclasses import dataclass
from typing import Any

import mujoco
import numpy as np

from humanoid.physics.build import Robot
from humanoid.walking.seam import Sensed


@dataclass(frozen=True)
class Noise:
    """The noise of the sensors as standard deviations, and their delay as a number of readings."""

    turn_rate: float = 0.002  # rad/s
    acceleration: float = 0.02  # m/s²
    angle: float = 0.0002  # rad
    speed: float = 0.002  # rad/s
    load: float = 1.0  # N
    delay: int = 0  # in readings, one each 5 ms

    def times(self, factor: float) -> Noise:
        """Return the same noise, `factor` times as large."""
        return Noise(
            self.turn_rate * factor,
            self.acceleration * factor,
            self.angle * factor,
            self.speed * factor,
            self.load * factor,
            self.delay,
        )


USUAL = Noise()
SILENT = USUAL.times(0.0)


class Senses:
    """The inertial sensor, the encoders and the soles of one simulated robot."""

    def __init__(self, robot: Robot, data: Any, noise: Noise, seed: int) -> None:
        self._robot, self._data, self.noise = robot, data, noise
        self._chance = np.random.default_rng(seed)
        self._late: deque[Sensed] = deque(maxlen=noise.delay + 1)
        self._foot_of_body = {leg.foot: side for side, leg in enumerate(robot.legs)}

    @property
    def last(self) -> Sensed:
        """The newest reading, without delay."""
        return self._late[-1]

    def read(self) -> Sensed:
        """Read all sensors once; return the reading from `delay` readings ago."""
        data, robot, noise = self._data, self._robot, self.noise
        reading = Sensed(
            data.sensor('base_gyro').data + self._spread(noise.turn_rate, 3),
            data.sensor('base_accelerometer').data + self._spread(noise.acceleration, 3),
            data.qpos[robot.qpos] + self._spread(noise.angle, len(robot.qpos)),
            data.qvel[robot.dofs] + self._spread(noise.speed, len(robot.dofs)),
            np.maximum(np.array(self.loads()) + self._spread(noise.load, 2), 0.0),
        )
        self._late.append(reading)
        return self._late[0]

    def _spread(self, deviation: float, size: int) -> Any:
        return self._chance.standard_normal(size) * deviation

    def loads(self) -> tuple[float, float]:
        """The force of the floor on the left and the right sole, in N."""
        robot, data = self._robot, self._data
        loads, force = [0.0, 0.0], np.zeros(6)
        geoms = data.contact.geom
        for number in range(data.ncon):
            one, other = geoms[number]
            if robot.floor not in (one, other):
                continue
            body = robot.model.geom_bodyid[one if other == robot.floor else other]
            side = self._foot_of_body.get(int(body))
            if side is not None:
                mujoco.mj_contactForce(robot.model, data, number, force)
                loads[side] += float(force[0])
        return loads[0], loads[1]
