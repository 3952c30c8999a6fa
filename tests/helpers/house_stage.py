"""The house without ROS: a base that carries tasks out in simulated time, as its scanner sees it."""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np
from builtin_interfaces.msg import Time
from humanoid.maps import read
from humanoid.navigation.base import Base, Pose2D, compose
from humanoid.route.costmap import Costmap
from humanoid.route.task import Task
from humanoid.world.file import load
from humanoid.world.messages import occupancy
from humanoid.world.scene import Scene, beam_angles

TICK = 0.05  # s
LASER = Pose2D(0.07, 0.0, 0.0)


class Stage:
    """The house, a base in it, and what its scanner has seen."""

    def __init__(self) -> None:
        self.scene = Scene(load('house'))
        self.costmap = Costmap(*read(occupancy(self.scene.file.solids, 0.05, Time())))
        self.base = Base()
        self.now = 0.0
        self.nearest = math.inf  # m between the robot's outline and anything, at least, so far
        self._chance = np.random.default_rng(3)

    def carry_out(
        self, task: Task, limit: float = 120.0, meanwhile: Callable[[], None] = lambda: None
    ) -> None:
        """Until the task ends; at most `limit` s. `meanwhile` is called in each tick."""
        ticks = 0
        while task.ending is None and ticks * TICK < limit:
            if ticks % 2 == 0:
                laser = compose(self.base.pose, LASER)
                ranges = self.scene.scan(laser, 0.7, 0.01, self._chance)
                self.costmap.see(laser, beam_angles(), ranges, self.now)
            self.base.drive_at(task.tick(self.costmap, self.base.pose, self.now))
            self.base.step(TICK)
            self.scene.step(TICK, self.base.pose)
            self.nearest = min(self.nearest, self.scene.clearance(self.base.pose))
            self.now, ticks = self.now + TICK, ticks + 1
            meanwhile()
