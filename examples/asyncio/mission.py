"""The humanoid's mission in the asyncio API: all its services and actions. Other half: `humanoid up`.

python examples/asyncio/mission.py

The same ten steps as humanoid/mission/, which does them with rclpy.
"""

import asyncio
import sys
import time
from collections.abc import Awaitable, Callable
from contextlib import suppress
from typing import Any

from geometry_msgs.msg import Point, Pose, PoseStamped, Quaternion
from humanoid.model import JOINTS
from humanoid_interfaces.action import MoveArm, MoveToPosition
from humanoid_interfaces.srv import GetBatteryStatus, GetJointState
from std_msgs.msg import Header

import goalwire

ANSWER_WITHIN = 2.0  # s for a service call
GOAL_WITHIN = 12.0  # s for a whole goal
RAISED = {'left_arm_shoulder': 1.5, 'left_arm_elbow': 1.0}
LOWERED = {'left_arm_shoulder': 0.5, 'left_arm_elbow': 0.0}


class NotAsExpected(Exception):
    """The robot did something else; the text says what."""


def expect(truth: bool, happened: str) -> None:
    if not truth:
        raise NotAsExpected(happened)


class Robot:
    """The abilities of the robot."""

    def __init__(self, node: goalwire.Node) -> None:
        self._joints = node.client(GetJointState, 'get_joint_state')
        self._battery = node.client(GetBatteryStatus, 'get_battery_status')
        self._base = node.action(MoveToPosition, 'move_to_position')
        self._arm = node.action(MoveArm, 'move_arm')

    async def joint(self, name: str) -> GetJointState.Response:
        return await self._joints.call(joint_name=name, timeout=ANSWER_WITHIN)

    async def battery(self, within: float = ANSWER_WITHIN) -> GetBatteryStatus.Response:
        return await self._battery.call(timeout=within)

    def drive(
        self, x: float, y: float, z: float = 0.0, *, allowed: float = 10.0
    ) -> goalwire.Run[MoveToPosition.Result, MoveToPosition.Feedback]:
        pose = Pose(position=Point(x=x, y=y, z=z), orientation=Quaternion(w=1.0))
        target = PoseStamped(header=Header(frame_id='odom'), pose=pose)
        return self._base.send(MoveToPosition.Goal(target_pose=target, timeout=allowed), timeout=GOAL_WITHIN)

    def reach(
        self, joints: dict[str, float], duration: float = 1.5
    ) -> goalwire.Run[MoveArm.Result, MoveArm.Feedback]:
        names, angles = list(joints), list(joints.values())
        return self._arm.send(joint_names=names, positions=angles, duration=duration, timeout=GOAL_WITHIN)


async def battery(robot: Robot) -> str:
    status = await robot.battery(within=10.0)  # the service may still be down: the call waits for it
    charge = status.battery.percentage
    expect(0.0 < charge <= 1.0, f'a charge of {charge:.3f}')
    return f'{charge:.1%}, {status.time_remaining.sec // 60} min left'


async def every_joint(robot: Robot) -> str:
    states = await asyncio.gather(*(robot.joint(joint.name) for joint in JOINTS))
    for joint, state in zip(JOINTS, states, strict=True):
        expect(joint.lower <= state.position <= joint.upper, f'{joint.name} at {state.position} rad')
    unknown = await robot.joint('tail')
    expect(unknown.position == 0.0 and not unknown.is_moving, f'a joint that is not there: {unknown}')
    return f'{len(JOINTS)} joints within limits, zeros for an unknown one'


async def raise_arm(robot: Robot) -> str:
    seen_moving = False
    async with robot.reach(RAISED) as run:
        async for _ in run.feedback:
            seen_moving = seen_moving or (await robot.joint('left_arm_shoulder')).is_moving
        await run.result
    shoulder = (await robot.joint('left_arm_shoulder')).position
    expect(abs(shoulder - RAISED['left_arm_shoulder']) < 0.02, f'the shoulder stands at {shoulder:.3f} rad')
    expect(seen_moving, 'the shoulder was never seen moving')
    return f'reached, shoulder seen moving, now at {shoulder:.2f} rad'


async def refused(run: goalwire.Run[Any, Any]) -> str:
    try:
        async with run:
            raise NotAsExpected('accepted')
    except goalwire.GoalRefused:
        return 'refused'


async def drive(robot: Robot) -> str:
    async with robot.drive(1.2, 0.9) as run:
        at = (await run.result).final_pose.pose.position
    expect(abs(at.x - 1.2) < 0.01 and abs(at.y - 0.9) < 0.01, f'it stands at ({at.x:.2f}, {at.y:.2f}) m')
    return f'reached ({at.x:.2f}, {at.y:.2f}) m'


async def cancel_half_way(robot: Robot) -> str:
    async with robot.drive(4.2, 0.9) as run:
        first = await anext(run.feedback)
        async for feedback in run.feedback:
            if feedback.distance_remaining <= first.distance_remaining / 2:
                break
        await run.cancel()
        try:
            result = await run.result
            raise NotAsExpected('it got there nonetheless')
        except goalwire.GoalCanceled as canceled:
            result = canceled.result
    x = result.final_pose.pose.position.x
    expect(2.4 < x < 4.0, f'cancelled at x = {x:.2f} m, half-way is 2.70 m')
    return f'cancelled at x = {x:.2f} m'


async def pre_empt(robot: Robot) -> str:
    async with robot.drive(9.0, 9.0, allowed=30.0) as older:
        await anext(older.feedback)
        async with robot.drive(2.0, 0.9) as newer:
            why = await aborted(older)
            await newer.result
    return f'older {why}, newer reached'


async def aborted(run: goalwire.Run[Any, Any]) -> str:
    try:
        await run.result
    except goalwire.GoalAborted as failure:
        return f'aborted: {failure.result.message}'
    raise NotAsExpected('reached')


async def too_little_time(robot: Robot) -> str:
    async with robot.drive(9.0, 9.0, allowed=0.5) as run:
        return await aborted(run)


async def home_with_lowered_arm(robot: Robot) -> str:
    before = (await robot.battery()).battery.charge
    async with robot.reach(LOWERED) as arm, robot.drive(0.0, 0.0) as base:
        await asyncio.gather(arm.result, base.result)
    drained = before - (await robot.battery()).battery.charge
    expect(drained > 0.0, f'the battery gained {-1000 * drained:.1f} mAh on the way')
    return f'both reached, {1000 * drained:.0f} mAh drained'


STEPS: dict[str, Callable[[Robot], Awaitable[str]]] = {
    'battery': battery,
    'ask every joint': every_joint,
    'raise the left arm': raise_arm,
    'arm beyond its limits': lambda robot: refused(robot.reach({'left_arm_elbow': 9.0}, duration=10.0)),
    'drive to (1.2, 0.9)': drive,
    'drive, cancel half-way': cancel_half_way,
    'drive below the floor': lambda robot: refused(robot.drive(1.0, 0.0, -1.0)),
    'newer goal while driving': pre_empt,
    'drive with too little time': too_little_time,
    'home, lowering the arm': home_with_lowered_arm,
}


async def main() -> int:
    """Carry out every step; return how many did not end as expected."""
    failed = 0
    async with goalwire.Node('mission') as node:
        robot = Robot(node)
        for name, step in STEPS.items():
            began = time.monotonic()
            try:
                mark, happened = 'ok', await step(robot)
            except (NotAsExpected, goalwire.CallError) as failure:
                mark, happened = 'FAILED', str(getattr(failure, 'result', '') or failure)
                failed += 1
            print(f'{mark:8}{name}: {happened} ({time.monotonic() - began:.1f} s)', flush=True)
    return failed


if __name__ == '__main__':
    with suppress(KeyboardInterrupt):  # its goals were cancelled
        sys.exit(asyncio.run(main()))
    sys.exit(130)
