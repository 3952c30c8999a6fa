"""The humanoid in its house, given random goals: benchmarks/house_goals.py [--goals N] [--minutes M].

Brings the robot up with --world house and sends one goal of NavigateToPose after the other, to random places
at which the map has room; before some of them a door is opened or closed. People walk about meanwhile. Prints
a table: how the goals ended, how near anything came to the robot, and how far off the localiser was, both
against the simulation's truth. --physics takes MuJoCo's body, which feels what it touches. Ends with 1 if the
body felt anything; without physics, if anything came into the robot's disc. --minutes sends no further goal
after so many minutes; --seed chooses other goals.
"""

from __future__ import annotations

import argparse
import math
import os
import random
import sys
import time
from collections import Counter, OrderedDict
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

ROOT = Path(__file__).resolve().parents[1]
sys.path.insert(0, str(ROOT / 'robot' / 'humanoid'))

import rclpy  # noqa: E402
from geometry_msgs.msg import PoseWithCovarianceStamped  # noqa: E402
from humanoid.model import BASE  # noqa: E402
from humanoid_interfaces.msg import Contacts  # noqa: E402
from nav2_msgs.action import NavigateToPose  # noqa: E402
from nav_msgs.msg import Odometry  # noqa: E402
from rclpy.action import ActionClient  # noqa: E402
from std_msgs.msg import Float64  # noqa: E402

if TYPE_CHECKING:
    from humanoid.mission.calls import GoalRun
    from humanoid.mission.robot import Robot
    from humanoid.navigation.base import Pose2D
    from humanoid.supervisor import Supervisor

Client = ActionClient[NavigateToPose.Goal, NavigateToPose.Result, NavigateToPose.Feedback]
DOMAIN = '96'
GOAL_WITHIN = 300.0  # s
READY_WITHIN = 120.0  # s
DOOR_MOVES = 0.3  # share of the goals before which a door is moved
ROOM = BASE.radius + 0.12  # m that the map has around a goal
REMEMBERED = 500  # truths, each with the stamp of its odometry


class Watch:
    """The facts about a run, from the simulation's truth."""

    def __init__(self, robot: Robot) -> None:
        self.nearest = math.inf  # m between the robot's disc and anything
        self.entries = 0
        """How often anything came into the disc."""
        self.off: list[float] = []  # m, of the localiser at each scan
        self.turned_off: list[float] = []  # degrees
        self.way = 0.0  # m
        self.felt: Counter[str] = Counter()
        """How often, at 50 Hz, each link felt a thing; only with physics."""
        self._is_entered = False
        self._truths: OrderedDict[tuple[int, int], Pose2D] = OrderedDict()
        from humanoid.navigation.truth import TRUTH

        robot.node.create_subscription(Odometry, TRUTH, self._hear_truth, 100)
        robot.node.create_subscription(PoseWithCovarianceStamped, 'amcl_pose', self._hear_belief, 100)
        robot.node.create_subscription(Float64, 'clearance', self._hear_clearance, 100)
        robot.node.create_subscription(Contacts, 'contacts', self._hear_contacts, 100)

    def _hear_truth(self, truth: Odometry) -> None:
        from humanoid.navigation.messages import target_of

        pose, stamp = target_of(truth.pose.pose), truth.header.stamp
        if self._truths:
            before = next(reversed(self._truths.values()))
            self.way += math.hypot(pose.x - before.x, pose.y - before.y)
        self._truths[stamp.sec, stamp.nanosec] = pose
        if len(self._truths) > REMEMBERED:
            self._truths.popitem(last=False)

    def _hear_belief(self, belief: PoseWithCovarianceStamped) -> None:
        from humanoid.navigation.base import turn_between
        from humanoid.navigation.messages import target_of

        true = self._truths.get((belief.header.stamp.sec, belief.header.stamp.nanosec))
        if true is not None:
            found = target_of(belief.pose.pose)
            self.off.append(math.hypot(found.x - true.x, found.y - true.y))
            self.turned_off.append(abs(math.degrees(turn_between(found.yaw, true.yaw))))

    def _hear_contacts(self, contacts: Contacts) -> None:
        self.felt.update(f'{contact.thing} by {contact.link}' for contact in contacts.contacts)

    def _hear_clearance(self, clearance: Float64) -> None:
        self.nearest = min(self.nearest, clearance.data)
        if clearance.data <= 0.0 and not self._is_entered:
            self.entries += 1
        self._is_entered = clearance.data <= 0.0


def random_goal(chance: random.Random) -> Pose2D:
    """A place in the house at which the robot has room, by the map."""
    from humanoid.navigation.base import Pose2D
    from humanoid.world.file import load
    from humanoid.world.solids import Outlines

    outlines = Outlines(load('house').solids)
    while True:
        x, y = chance.uniform(-1.9, 10.4), chance.uniform(-1.9, 10.4)
        if outlines.distance(np.array([[x, y]]))[0] >= ROOM:
            return Pose2D(x, y, chance.uniform(-math.pi, math.pi))


def send(client: Client, to: Pose2D) -> GoalRun:
    from humanoid.mission.calls import GoalRun

    goal = NavigateToPose.Goal()
    goal.pose.header.frame_id = 'map'
    goal.pose.pose.position.x, goal.pose.pose.position.y = to.x, to.y
    goal.pose.pose.orientation.z, goal.pose.pose.orientation.w = math.sin(to.yaw / 2), math.cos(to.yaw / 2)
    return GoalRun(client, 'navigate_to_pose', goal, GOAL_WITHIN)


def bring_up(supervisor: Supervisor, *, physics: bool) -> None:
    """Start the robot in the house; return when it takes goals."""
    from humanoid.supervisor import Printed, program

    supervisor.start('up', program('up', '--world', 'house', '--physics' if physics else '--no-physics'))
    deadline = time.monotonic() + READY_WITHIN
    while event := supervisor.next_event(deadline):
        if isinstance(event, Printed) and 'Navigator ready' in event.line:
            return
    raise SystemExit('humanoid up did not come up')


def run(robot: Robot, watch: Watch, goals: int, until: float, chance: random.Random) -> Counter[str]:
    """Send the goals, one after the other, but none after `until`; how they ended."""
    endings: Counter[str] = Counter()
    client = ActionClient(robot.node, NavigateToPose, 'navigate_to_pose')
    doors = robot.doors()
    for number in range(1, goals + 1):
        if time.monotonic() > until:
            break
        if chance.random() < DOOR_MOVES:
            robot.move_door(chance.choice(doors), is_open=chance.random() < 0.6)
        to, began, recoveries = random_goal(chance), time.monotonic(), 0
        with send(client, to) as goal:
            for feedback in goal.feedback():
                recoveries = feedback.number_of_recoveries
            if goal.accepted:
                ending, why = goal.status, goal.result.error_msg
            else:
                ending, why = 'REFUSED', ''
        endings[ending] += 1
        took = time.monotonic() - began
        print(
            f'{number}: ({to.x:.1f}, {to.y:.1f}) {ending} {took:.0f} s, {recoveries} recoveries, '
            f'nearest {watch.nearest:.3f} m, entries {watch.entries}, felt {watch.felt.total()} {why}',
            flush=True,
        )
    client.destroy()
    return endings


def report(endings: Counter[str], watch: Watch, took: float) -> str:
    """The table, in Markdown."""
    off, turned = np.array(watch.off), np.array(watch.turned_off)
    felt = ', '.join(f'{what} {count}' for what, count in watch.felt.items())
    rows = [
        ('goals', str(sum(endings.values()))),
        ('reached', str(endings['SUCCEEDED'])),
        ('aborted, with the reason', str(endings['ABORTED'])),
        ('refused', str(endings['REFUSED'])),
        ('way, time', f'{watch.way:.0f} m, {took / 60:.0f} min'),
        ('felt, so many times', felt or 'nothing'),
        ('anything in the disc, so many times', str(watch.entries)),
        ('nearest to the disc', f'{watch.nearest * 100:.1f} cm'),
        ('localiser off: median, 99 %, most', _three(off * 100, 'cm')),
        ('turned off: median, 99 %, most', _three(turned, '°')),
    ]
    return '\n'.join(['| | |', '|---|---|', *(f'| {name} | {value} |' for name, value in rows)])


def _three(values: np.ndarray[tuple[int, ...], np.dtype[np.float64]], unit: str) -> str:
    return ', '.join(f'{np.percentile(values, share):.1f} {unit}' for share in (50, 99, 100))


def main() -> int:
    """Measure."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument('--goals', type=int, default=100)
    parser.add_argument('--minutes', type=float, default=math.inf)
    parser.add_argument('--seed', type=int, default=0)
    parser.add_argument('--physics', action='store_true')
    options = parser.parse_args()
    os.environ.setdefault('ROS_DOMAIN_ID', DOMAIN)
    os.environ['PYTHONPATH'] = str(ROOT / 'robot' / 'humanoid')
    os.environ['GOALWIRE_INTERFACE_PATH'] = str(ROOT / 'robot')
    from humanoid.mission.robot import Robot
    from humanoid.supervisor import Supervisor

    with Supervisor() as supervisor:
        bring_up(supervisor, physics=options.physics)
        rclpy.init(args=[])
        with Robot('house_goals') as robot:
            watch, began = Watch(robot), time.monotonic()
            until = began + options.minutes * 60
            endings = run(robot, watch, options.goals, until, random.Random(options.seed))
            print(report(endings, watch, time.monotonic() - began))
        rclpy.shutdown()
    return 1 if watch.felt or (watch.entries and not options.physics) else 0


if __name__ == '__main__':
    raise SystemExit(main())
