"""The thirteen steps of `humanoid demo` as one durable mission: kill it anywhere, start it again, it goes on.

humanoid up
goalwire mission run examples/missions/thirteen.py:thirteen --id demo-1

Each goal is executed once, or the mission asks. If only its runner dies, it asks about two calls, which a
server cannot recognise when they come twice: the wave, and the release of the emergency stop. If the robot
does not do what it should, for example since its servers were restarted, the mission asks, too.
"""

from __future__ import annotations

import math
from collections.abc import Awaitable, Callable
from typing import Any

from control_msgs.action import GripperCommand
from control_msgs.msg import GripperCommand as Grip
from geometry_msgs.msg import Point, Pose, PoseStamped, Quaternion
from humanoid.model import JOINTS
from humanoid_interfaces.action import MoveArm, MoveToPosition
from humanoid_interfaces.srv import GetBatteryStatus, GetJointState
from nav_msgs.msg import Odometry
from sensor_msgs.msg import JointState
from std_msgs.msg import Bool, Header
from std_srvs.srv import SetBool, Trigger

import goalwire
from goalwire import CallError, DeadlineError, GoalAborted, GoalCanceled, GoalRefused
from goalwire.errors import StepLost
from goalwire.missions import SentGoal, Steps, mission

GOAL_WITHIN = 60.0  # s for a goal, the robot's turning included
ACCEPTED_WITHIN = 10.0  # s for a server to appear and to accept a goal
READ_WITHIN = 5.0  # s for an answer that only tells something; after three attempts the mission asks
SEEN_WITHIN = 20.0  # s until a topic shows what a step waits for
MEASURED_WITHIN = 0.01  # rad: a joint with mass may stand this far beyond its limit
MOVING_SPEED = 0.01  # rad/s
RAISED = {'left_arm_shoulder': 1.5, 'left_arm_elbow': 1.0}
LOWERED = {'left_arm_shoulder': 0.5, 'left_arm_elbow': 0.0}
HAND = 'left_gripper_controller/gripper_cmd'
LATCHED = goalwire.QoS(depth=1, durability=goalwire.DurabilityPolicy.TRANSIENT_LOCAL)


class Demo:
    """The robot for one mission: its actions and services, and a method for each of the thirteen steps."""

    def __init__(self, m: Steps) -> None:
        self._m = m
        self._base = m.action(MoveToPosition, 'move_to_position')
        self._arm = m.action(MoveArm, 'move_arm')
        self._hand = m.action(GripperCommand, HAND)
        self._joint = m.client(GetJointState, 'get_joint_state', idempotent=True)  # it only reads
        self._battery = m.client(GetBatteryStatus, 'get_battery_status', idempotent=True)
        self._wave = m.client(Trigger, 'wave')
        self._stop = m.client(SetBool, 'emergency_stop', idempotent=True)  # to throw it twice does no harm
        # Somebody else may have thrown the switch meanwhile, so the release is not repeated without a person.
        self._release = m.client(SetBool, 'emergency_stop')

    async def battery(self) -> str:
        """Ask for the battery's state, also while its server is not there yet."""
        status = await self._battery.call(timeout=1.0, attempts=10, pause=0.5)
        await self._expect(0.0 < status.battery.percentage <= 1.0, 'the battery has no charge')
        return f'{status.battery.percentage:.0%}'

    async def every_joint(self) -> str:
        """Ask for each joint, and for one that does not exist."""
        for joint in JOINTS:
            at = (await self._read_joint(joint.name)).position
            within = joint.lower - MEASURED_WITHIN <= at <= joint.upper + MEASURED_WITHIN
            await self._expect(within, f'{joint.name} at {at:.2f} {joint.unit}')
        unknown = await self._read_joint('tail')
        await self._expect(
            not unknown.position and not unknown.is_moving, 'a joint answers that does not exist'
        )
        return f'{len(JOINTS)} joints within limits'

    async def raise_arm(self) -> str:
        """Raise the arm, and see it move."""
        async with self._arm.send(reach(RAISED), timeout=ACCEPTED_WITHIN) as raising:
            await self._see(JointState, 'joint_states', is_raising)
            await raising.result(timeout=GOAL_WITHIN)
        return 'raised, seen in the joints'

    async def arm_beyond_limits(self) -> str:
        return await self._refused(
            self._arm.call(reach({'left_arm_elbow': 9.0}, 10.0), timeout=ACCEPTED_WITHIN)
        )

    async def drive(self) -> str:
        result = await self._base.call(to(1.2, 0.9), timeout=GOAL_WITHIN)
        at = result.final_pose.pose.position
        await self._expect(
            math.dist((at.x, at.y), (1.2, 0.9)) < 0.1, f'it stands at ({at.x:.2f}, {at.y:.2f}) m'
        )
        return f'at ({at.x:.2f}, {at.y:.2f}) m'

    async def cancel_half_way(self) -> str:
        async with self._base.send(to(4.2, 0.9), timeout=ACCEPTED_WITHIN) as driving:
            await self._see(Odometry, 'odom', lambda odom: beyond(odom, 2.7))
            await driving.cancel()
            try:
                await driving.result(timeout=GOAL_WITHIN)
            except GoalCanceled as end:
                x = end.result.final_pose.pose.position.x
                await self._expect(2.4 < x < 4.0, f'cancelled at x = {x:.2f} m')
                return f'cancelled at x = {x:.2f} m'
        await self._ask('it got there although it was cancelled')
        return 'not cancelled'

    async def drive_below_floor(self) -> str:
        return await self._refused(self._base.call(to(1.0, 0.0, -1.0), timeout=ACCEPTED_WITHIN))

    async def newer_goal(self) -> str:
        """Send a newer goal while the base drives to an older one."""
        async with self._base.send(to(9.0, 9.0), timeout=ACCEPTED_WITHIN) as older:
            await self._see(Odometry, 'odom', is_driving)
            await self._base.call(to(2.0, 0.9), timeout=GOAL_WITHIN)
            return f'older {await self._aborted(older)}, newer reached'

    async def too_little_time(self) -> str:
        async with self._base.send(to(9.0, 9.0, allowed=0.5), timeout=ACCEPTED_WITHIN) as driving:
            return await self._aborted(driving)

    async def home_lowering_the_arm(self) -> str:
        before = await self._read_charge()
        async with (
            self._arm.send(reach(LOWERED), timeout=ACCEPTED_WITHIN) as lowering,
            self._base.send(to(0.0, 0.0), timeout=ACCEPTED_WITHIN) as driving,
        ):
            await lowering.result(timeout=GOAL_WITHIN)
            await driving.result(timeout=GOAL_WITHIN)
        drained = before - await self._read_charge()
        await self._expect(drained > 0.0, 'the battery was not drained on the way')
        return f'both reached, {1000 * drained:.0f} mAh drained'

    async def wave(self) -> str:
        answer = await self._wave.call(timeout=GOAL_WITHIN)
        await self._expect(answer.success, answer.message)
        return answer.message

    async def grip(self) -> str:
        for gap in (0.05, 0.0):
            result = await self._hand.call(command=Grip(position=gap), timeout=GOAL_WITHIN)
            await self._expect(
                abs(result.position - gap) < 0.003, f'the fingers are {result.position:.3f} m apart'
            )
        return 'opened and closed'

    async def emergency_stop(self) -> str:
        """Throw the emergency stop during two goals; they end, others are refused until the release."""
        shoulder = reach({'left_arm_shoulder': 2.0}, 10.0)
        async with (
            self._arm.send(shoulder, timeout=ACCEPTED_WITHIN) as reaching,
            self._base.send(to(9.0, 9.0), timeout=ACCEPTED_WITHIN) as driving,
        ):
            await self._see(Odometry, 'odom', lambda odom: beyond(odom, 0.2))
            answer = await self._stop.call(data=True, timeout=5.0)
            await self._expect(answer.success, answer.message)
            for sent in (driving, reaching):
                await self._aborted(sent)
        await self._see(JointState, 'joint_states', stands_still)
        await self._refused(self._base.call(to(0.0, 0.0), timeout=ACCEPTED_WITHIN))
        await self._refused(self._arm.call(reach(LOWERED), timeout=ACCEPTED_WITHIN))
        answer = await self._release.call(data=False, timeout=5.0)
        await self._expect(answer.success, answer.message)
        await self._see(Bool, 'emergency_stopped', lambda told: not told.data, LATCHED)
        # The servers hear of the release by the same topic, maybe later: then a refused goal is sent anew.
        await self._base.call(to(0.0, 0.0), timeout=GOAL_WITHIN, attempts=10, pause=0.5)
        await self._arm.call(reach(LOWERED), timeout=GOAL_WITHIN, attempts=10, pause=0.5)
        return 'both aborted, both refused; released: both reached'

    async def carry_out(self, name: str, step: Callable[[], Awaitable[str]]) -> str:
        """Carry out one of the thirteen steps; if it fails, ask a person whether to do it again."""
        while True:
            try:
                return await step()
            except (CallError, StepLost) as error:
                if not await self._m.approve(f'{name} failed: {error}: do it again?'):
                    self._m.give_up(f'{name} failed: {error}')

    async def _read_joint(self, name: str) -> GetJointState.Response:
        return await self._joint.call(joint_name=name, timeout=READ_WITHIN, attempts=3)

    async def _read_charge(self) -> float:
        """Return the battery's charge, in Ah."""
        return (await self._battery.call(timeout=READ_WITHIN, attempts=3)).battery.charge

    async def _aborted(self, sent: SentGoal[Any]) -> str:
        try:
            await sent.result(timeout=GOAL_WITHIN)
        except GoalAborted as end:
            return f'aborted: {end.result.message}'
        await self._ask('a goal was reached that had to be aborted')
        return 'not aborted'

    async def _refused(self, goal: Awaitable[Any]) -> str:
        try:
            await goal
        except GoalRefused:
            return 'refused'
        await self._ask('a goal was accepted that had to be refused')
        return 'not refused'

    async def _see(
        self,
        message_type: type[Any],
        topic: str,
        condition: Callable[[Any], bool],
        qos: goalwire.QoS | int = 10,
    ) -> None:
        """Wait until a topic shows something. A robot that was restarted meanwhile may never show it."""
        try:
            await self._m.wait(message_type, topic, condition, timeout=SEEN_WITHIN, qos=qos)
        except DeadlineError as error:
            await self._ask(str(error))

    async def _expect(self, truth: bool, happened: str) -> None:
        """Ask a person if the robot did something else."""
        if not truth:
            await self._ask(happened)

    async def _ask(self, happened: str) -> None:
        if not await self._m.approve(f'{happened}: go on?'):
            self._m.give_up(happened)


@mission(version=1, timeout=1800.0)
async def thirteen(m: Steps) -> dict[str, str]:
    """Carry out the thirteen steps; return what happened in each."""
    demo = Demo(m)
    steps: dict[str, Callable[[], Awaitable[str]]] = {
        'battery': demo.battery,
        'ask every joint': demo.every_joint,
        'raise the left arm': demo.raise_arm,
        'arm beyond its limits': demo.arm_beyond_limits,
        'drive to (1.2, 0.9)': demo.drive,
        'drive, cancel half-way': demo.cancel_half_way,
        'drive below the floor': demo.drive_below_floor,
        'newer goal while driving': demo.newer_goal,
        'drive with too little time': demo.too_little_time,
        'home, lowering the arm': demo.home_lowering_the_arm,
        'wave': demo.wave,
        'open and close the left hand': demo.grip,
        'emergency stop': demo.emergency_stop,
    }
    return {name: await demo.carry_out(name, step) for name, step in steps.items()}


def to(x: float, y: float, z: float = 0.0, *, allowed: float = 50.0) -> MoveToPosition.Goal:
    """Return the goal to drive to a place, in m from where the robot started, within `allowed` s."""
    pose = Pose(position=Point(x=x, y=y, z=z), orientation=Quaternion(w=1.0))
    return MoveToPosition.Goal(
        target_pose=PoseStamped(header=Header(frame_id='odom'), pose=pose), timeout=allowed
    )


def reach(joints: dict[str, float], duration: float = 1.5) -> MoveArm.Goal:
    """Return the goal to move joints to angles in rad, in `duration` s."""
    return MoveArm.Goal(joint_names=list(joints), positions=list(joints.values()), duration=duration)


def beyond(odometry: Odometry, x: float) -> bool:
    return odometry.pose.pose.position.x > x


def is_driving(odometry: Odometry) -> bool:
    speed = odometry.twist.twist.linear
    return math.hypot(speed.x, speed.y) > 0.1  # m/s


def is_raising(states: JointState) -> bool:
    """Return whether the shoulder moves, or has been raised."""
    number = list(states.name).index('left_arm_shoulder')
    return abs(states.velocity[number]) > MOVING_SPEED or states.position[number] > 1.0


def stands_still(states: JointState) -> bool:
    return all(abs(speed) < MOVING_SPEED for speed in states.velocity)
