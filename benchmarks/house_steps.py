"""The body in physics in its house, without ROS: benchmarks/house_steps.py [--goals N] [--seed S].

Random goals, doors that move and people, as in house_goals.py. The navigator's task, the guard and the body
are called in lock step with the world's time, four to five times as fast as real time on one core. Localiser
and wire are left out: the navigator knows the true pose, and gets each scan 30 ms late. Prints how each goal
ended, and a table. Ends with 1 if the body felt anything. It helps to compare two versions of the navigator;
house_goals.py is the judge.
"""

from __future__ import annotations

import argparse
import math
import random
import sys
from collections import Counter, deque
from dataclasses import dataclass, field
from functools import partial
from pathlib import Path

import numpy as np

ROOT = Path(__file__).resolve().parents[1]
sys.path.insert(0, str(ROOT))
sys.path.insert(0, str(ROOT / 'robot' / 'humanoid'))

from builtin_interfaces.msg import Time  # noqa: E402
from humanoid.description import urdf_text  # noqa: E402
from humanoid.maps import Array, read  # noqa: E402
from humanoid.model import DESCRIPTION, JOINTS  # noqa: E402
from humanoid.navigation.base import STANDING, Pose2D, compose  # noqa: E402
from humanoid.navigation.guard import Guard  # noqa: E402
from humanoid.physics.base import PhysicsBase  # noqa: E402
from humanoid.physics.joints import PhysicsJoints  # noqa: E402
from humanoid.physics.surroundings import Surroundings, body_name  # noqa: E402
from humanoid.physics.world import TICK, World  # noqa: E402
from humanoid.route.costmap import Costmap  # noqa: E402
from humanoid.route.errand import Errand  # noqa: E402
from humanoid.world.file import load  # noqa: E402
from humanoid.world.messages import laser_scan, occupancy  # noqa: E402
from humanoid.world.scene import Scene, beam_angles  # noqa: E402
from humanoid.world.solids import Block  # noqa: E402

from benchmarks.house_goals import DOOR_MOVES, GOAL_WITHIN, random_goal  # noqa: E402

LASER = DESCRIPTION.pose('laser', {}).translation
BASE_EVERY, WORLD_EVERY, SCAN_EVERY, BODIES_EVERY = 2, 5, 10, 20  # ticks: as the programs of the robot do
SCAN_LATE = 3  # ticks
SCAN_NOISE = 0.01  # m


@dataclass
class Facts:
    """The measurements of a run."""

    endings: Counter[str] = field(default_factory=Counter)
    felt: Counter[str] = field(default_factory=Counter)
    """How often, at 50 Hz, each link felt a thing."""
    touches = 0
    entries = 0
    """How often anything came into the robot's disc."""
    nearest = math.inf  # m between the disc and anything
    way = 0.0  # m
    recoveries = 0


class House:
    """The house with the robot in it, tick by tick."""

    def __init__(self, seed: int) -> None:
        file = load('house')
        self.scene, self.facts, self.ticks = Scene(file), Facts(), 0
        self._around = Surroundings(file)
        home = {joint.name: joint.home for joint in JOINTS}
        self._world = World(urdf_text(), home, seed, around=self._around.add)
        self._base = PhysicsBase(self._world)
        PhysicsJoints(self._world)  # its arms swing
        self._costmap, self._guard = Costmap(*read(occupancy(file.solids, 0.05, Time()))), Guard()
        self._start, self._noise = Pose2D(*file.start), np.random.default_rng(seed)
        self._scans: deque[tuple[int, Pose2D, Array]] = deque()
        self._wish, self._before = STANDING, self.pose
        self._touches = self._is_entered = False
        self._place_bodies()

    @property
    def pose(self) -> Pose2D:
        """The robot's true pose on the map."""
        return compose(self._start, self._world.true_pose)

    @property
    def now(self) -> float:
        return self.ticks * TICK

    def carry_out(self, goal: Pose2D) -> str:
        """Go to a goal; return how that ended."""
        task, began = Errand([goal], self.now), self.now
        while task.ending is None and self.now - began < GOAL_WITHIN and not self._world.fallen:
            self._tick(task)
        self._wish = STANDING
        self.facts.recoveries += task.recoveries
        if self._world.fallen:
            self.facts.endings['FELL'] += 1
            self._world.get_up()
            return 'FELL'
        ending = 'TIMED OUT' if task.ending is None else task.ending.end.name
        self.facts.endings[ending] += 1
        why = '' if task.ending is None or task.ending.success else f' {task.ending.message}'
        return f'{ending} {self.now - began:.0f} s, {task.recoveries} recoveries{why}'

    def _tick(self, task: Errand) -> None:
        self._world.tick()
        self.ticks += 1
        if self.ticks % BASE_EVERY == 0:
            pose = self._base.pose
            self._guard.note_pose(self.now, pose)
            self._base.drive_at(self._guard.limit(self._wish, pose, self.now))
            self._feel()
        if self.ticks % WORLD_EVERY == 0:
            self.scene.step(WORLD_EVERY * TICK, self.pose)
            if self.ticks % SCAN_EVERY == 0:
                self._look()
            self._wish = task.tick(self._costmap, self.pose, self.now)
        if self.ticks % BODIES_EVERY == 0:
            self._place_bodies()
        if self._scans and self._scans[0][0] + SCAN_LATE <= self.ticks:
            self._hear(*self._scans.popleft())

    def _feel(self) -> None:
        touches, facts, pose = self._world.touches(), self.facts, self.pose
        facts.felt.update(f'{touch.thing} by {touch.link}' for touch in touches)
        facts.touches += bool(touches) and not self._touches
        self._touches = bool(touches)
        facts.way += math.hypot(pose.x - self._before.x, pose.y - self._before.y)
        self._before = pose

    def _look(self) -> None:
        laser = compose(self.pose, Pose2D(LASER[0], LASER[1]))
        height = self._world.pelvis_height + LASER[2]
        self._scans.append((self.ticks, laser, self.scene.scan(laser, height, SCAN_NOISE, self._noise)))
        clearance = self.scene.clearance(self.pose)
        self.facts.nearest = min(self.facts.nearest, clearance)
        self.facts.entries += clearance <= 0.0 and not self._is_entered
        self._is_entered = clearance <= 0.0

    def _hear(self, taken: int, laser: Pose2D, ranges: Array) -> None:
        self._costmap.see(laser, beam_angles(), ranges, self.now)
        moment = round(taken * TICK * 1e9)
        stamp = Time(sec=moment // 10**9, nanosec=moment % 10**9)
        self._guard.hear(laser_scan(ranges, 'laser', stamp, SCAN_EVERY * TICK))

    def _place_bodies(self) -> None:
        """Move the bodies of doors and people to their places."""
        places = {
            body_name(solid.kind, solid.name): (
                solid.x,
                solid.y,
                solid.yaw if isinstance(solid, Block) else 0.0,
            )
            for solid in self.scene.moving
        }
        self._world.arrange(partial(self._around.arrange, places=places))


def main() -> int:
    """Measure."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument('--goals', type=int, default=25)
    parser.add_argument('--seed', type=int, default=1)
    options = parser.parse_args()
    house, chance = House(options.seed), random.Random(options.seed)
    for number in range(1, options.goals + 1):
        if chance.random() < DOOR_MOVES:
            door, opens = chance.choice(house.scene.file.doors).name, chance.random() < 0.6
            if opens or house.scene.can_close(door, house.pose):
                house.scene.open[door] = opens
        to = random_goal(chance)
        print(f'{number}: ({to.x:.1f}, {to.y:.1f}) {house.carry_out(to)}', flush=True)
    facts = house.facts
    print('\n| | |\n|---|---|')
    print(f'| ended | {", ".join(f"{ending} {count}" for ending, count in facts.endings.items())} |')
    print(f'| way, time | {facts.way:.0f} m, {house.now / 60:.1f} min |')
    print(f'| recoveries | {facts.recoveries} |')
    felt = ', '.join(f'{what} {count}' for what, count in facts.felt.items())
    print(f'| touches; felt, so many times at 50 Hz | {facts.touches}; {felt or "nothing"} |')
    print(f'| anything in the disc, nearest | {facts.entries} times, {facts.nearest * 100:.1f} cm |')
    return 1 if facts.touches else 0


if __name__ == '__main__':
    sys.exit(main())
