"""The humanoid on its feet: python -m benchmarks.walking [PART ...] [--runs N] [--seconds S] [--speed V].

`walks`: at 0.3, 0.5 and 0.8 m/s, each run with other masses and inertias (±10 %), another friction (0.5 to
1.2) and pushes of 100 N for 0.2 s from anywhere, at random moments. `moments`: 48 single pushes of 140 N,
at eight moments of a stride of six such robots; half of the pushes go sideways. It takes less than a minute,
to compare two walkers by the same pushes. `pushes`: the largest of 0.2 s that is survived, from eight
directions. `stand`: ten minutes. `far`: 100 m in one goal. Nothing but the simulation runs: no ROS, no real
time. Needs MuJoCo and daqp.
"""

from __future__ import annotations

import argparse
import math
import os
import random
import time
from collections.abc import Callable, Sequence
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass
from functools import partial
from typing import Any

from humanoid.description import urdf_text
from humanoid.model import JOINTS, BaseSpec
from humanoid.navigation.base import Pose2D, Velocity2D
from humanoid.physics.base import PhysicsBase
from humanoid.physics.joints import PhysicsJoints
from humanoid.physics.world import TICK, World
from humanoid.walking.gait import SHIFT, SWING

SPEEDS = (0.3, 0.5, 0.8)  # m/s
CHANGE = 0.1  # of each mass and inertia
FRICTION = (0.5, 1.2)
PUSH, PUSHED = 100.0, 0.2  # N, s
PUSH_EVERY = 10.0  # s, on average
BEGIN = 3.0  # s before speed and energy are measured
DIRECTIONS = range(0, 360, 45)  # degrees, from straight ahead to the left
FORCES = range(50, 651, 50)  # N
ROBOTS, MOMENTS = 6, 8  # of the part `moments`: other masses, inertias and friction; parts of a stride
STRIDE = 2.0 * (SHIFT + SWING)  # s
FIRST = 2.61  # s before the first of these pushes
HARD, AFTERWARDS = 140.0, 2.5  # N; s in which a robot falls, or does not
ASIDE = 40.0  # degrees: sideways pushes go at most this far from straight to the left or right
HOME = {joint.name: joint.home for joint in JOINTS}


@dataclass(frozen=True)
class Walk:
    fell_after: float | None  # s
    speed: float  # m/s
    power: float  # W
    factor: float  # simulated seconds a processor second


def changed(chance: random.Random) -> Callable[[Any], None]:
    """Another robot on another floor than the walker knows."""

    def change(model: Any) -> None:
        for body in range(model.nbody):
            share = 1.0 + chance.uniform(-CHANGE, CHANGE)
            model.body_mass[body] *= share
            model.body_inertia[body] *= share
        model.geom_friction[:, 0] = chance.uniform(*FRICTION)

    return change


def pushed(world: World, force: float, degrees: float) -> None:
    way = math.radians(degrees)
    world.push((force * math.cos(way), force * math.sin(way), 0.0), PUSHED)


def walk(speed: float, seconds: float, seed: int, *, disturbed: bool = True) -> Walk:
    chance = random.Random(seed)
    world = World(urdf_text(), HOME, seed, change=changed(chance) if disturbed else None)
    PhysicsJoints(world)  # its arms swing
    base = PhysicsBase(world, BaseSpec(max_speed=speed))
    base.drive_at(Velocity2D(speed))
    began, energy, way = time.process_time(), 0.0, 0.0
    last = world.true_pose
    while world.time < seconds and not world.fallen:
        if disturbed and world.time > BEGIN and chance.random() < TICK / PUSH_EVERY:
            pushed(world, PUSH, chance.uniform(0.0, 360.0))
        world.tick()
        here = world.true_pose
        if world.time > BEGIN:
            way += math.cos(last.yaw) * (here.x - last.x) + math.sin(last.yaw) * (here.y - last.y)
            energy += world.power * TICK
        last = here
    measured = max(world.time - BEGIN, TICK)
    factor = world.time / (time.process_time() - began)
    return Walk(world.time if world.fallen else None, way / measured, energy / measured, factor)


def walks(runs: int, seconds: float, speeds: Sequence[float]) -> None:
    print(f'{runs} runs of {seconds:g} s at each speed')
    print('asked m/s | falls | went m/s | W | times real time')
    for speed in speeds:
        with ProcessPoolExecutor() as cores:
            made = list(cores.map(partial(walk, speed, seconds), range(runs)))
        upright = [each for each in made if each.fell_after is None]
        falls = len(made) - len(upright)
        shown = upright or made
        print(
            f'{speed:g} | {falls} of {runs} | {mean([each.speed for each in shown]):.2f} | '
            f'{mean([each.power for each in shown]):.0f} | {mean([each.factor for each in made]):.1f}',
            flush=True,
        )


def moments(speed: float = 0.5) -> None:
    falls = []
    for seed in range(ROBOTS):
        chance = random.Random(seed)
        world = World(urdf_text(), HOME, seed, change=changed(chance))
        PhysicsJoints(world)
        PhysicsBase(world, BaseSpec(max_speed=speed)).drive_at(Velocity2D(speed))
        ticks(world, FIRST)
        for moment in range(MOMENTS):
            aside = chance.choice((90, 270)) + chance.uniform(-ASIDE, ASIDE) if moment % 2 == 0 else None
            degrees = chance.uniform(0.0, 360.0) if aside is None else aside
            if falls_if_pushed(world, degrees):
                falls.append(f'robot {seed}, moment {moment}, to {degrees:.0f} degrees')
            ticks(world, STRIDE / MOMENTS)
    print(f'{len(falls)} of {ROBOTS * MOMENTS} single pushes of {HARD:g} N at {speed:g} m/s end in a fall')
    print('\n'.join(falls), flush=True)


def falls_if_pushed(world: World, degrees: float) -> bool:
    """Push a copy of the world, in a process of its own, and return whether the robot falls."""
    child = os.fork()
    if child == 0:
        pushed(world, HARD, degrees)
        end = world.time + AFTERWARDS
        while world.time < end and not world.fallen:
            world.tick()
        os._exit(world.fallen)
    return os.waitstatus_to_exitcode(os.waitpid(child, 0)[1]) != 0


def survives(force: float, degrees: float, speed: float) -> bool:
    world = World(urdf_text(), HOME)
    base = PhysicsBase(world)
    base.drive_at(Velocity2D(speed))
    ticks(world, 3.0 if speed else 0.2)
    pushed(world, force, degrees)
    ticks(world, 3.0)
    return not world.fallen


def pushes() -> None:
    for speed in (0.0, 0.4):
        print(f'the largest push of {PUSHED} s survived at {speed:g} m/s')
        for degrees in DIRECTIONS:
            largest = 0
            for force in FORCES:
                if not survives(force, degrees, speed):
                    break
                largest = force
            print(f'{degrees} degrees | {largest} N', flush=True)


def stand(seconds: float) -> None:
    world = World(urdf_text(), HOME)
    begin = world.true_pose
    farthest = 0.0
    while world.time < seconds and not world.fallen:
        world.tick()
        farthest = max(farthest, math.dist((begin.x, begin.y), (world.true_pose.x, world.true_pose.y)))
    end = 'fell' if world.fallen else 'stood'
    print(f'{end} {world.time:.0f} s, at most {1000.0 * farthest:.1f} mm from where it began', flush=True)


def far(metres: float = 100.0) -> None:
    world = World(urdf_text(), HOME)
    base = PhysicsBase(world)
    base.drive_to(Pose2D(metres))
    while not base.arrived and not world.fallen and world.time < 20.0 * metres:
        world.tick()
    truth = world.true_pose
    end = 'arrived' if base.arrived else 'fell' if world.fallen else 'did not arrive'
    print(
        f'{metres:g} m: {end} after {world.time:.0f} s; by its odometry it is at '
        f'({base.pose.x:.2f}, {base.pose.y:.2f}), in truth at ({truth.x:.2f}, {truth.y:.2f})',
        flush=True,
    )


def ticks(world: World, seconds: float) -> None:
    for _ in range(round(seconds / TICK)):
        world.tick()


def mean(numbers: Sequence[float]) -> float:
    return sum(numbers) / len(numbers)


def main() -> None:
    parser = argparse.ArgumentParser(description=(__doc__ or '').partition('\n\n')[2])
    parser.add_argument('parts', nargs='*', help='walks, moments, pushes, stand, far; without any: all')
    parser.add_argument('--runs', type=int, default=200, help='walks at each speed (200)')
    parser.add_argument('--seconds', type=float, default=60.0, help='of each walk (60)')
    parser.add_argument('--speed', type=float, action='append', help='in m/s, of the walks (0.3, 0.5, 0.8)')
    options = parser.parse_args()
    parts = options.parts or ['walks', 'moments', 'pushes', 'stand', 'far']
    if 'walks' in parts:
        walks(options.runs, options.seconds, options.speed or SPEEDS)
    if 'moments' in parts:
        moments()
    if 'pushes' in parts:
        pushes()
    if 'stand' in parts:
        stand(600.0)
    if 'far' in parts:
        far()


if __name__ == '__main__':
    main()
