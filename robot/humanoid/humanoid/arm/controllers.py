"""The actions of ros2_control's controllers: FollowJointTrajectory for an arm, GripperCommand for a hand.

As in humanoid.arm.server, a timer's tick decides how a goal ends, and the goal's coroutine carries that out.
A newer goal replaces the running goal of its controller, which ends ABORTED. A goal for joints that a
`move_arm` goal is moving is refused.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any

from control_msgs.action import FollowJointTrajectory, GripperCommand
from rclpy.action import ActionServer, CancelResponse, GoalResponse
from rclpy.action.server import ServerGoalHandle
from rclpy.callback_groups import ReentrantCallbackGroup
from rclpy.node import Node
from trajectory_msgs.msg import JointTrajectory, JointTrajectoryPoint

from humanoid.arm.limbs import LOST, Limbs
from humanoid.arm.trajectory import Following, Verdict, refusal
from humanoid.clock import duration_msg, now, stamp
from humanoid.emergency.listener import StopListener
from humanoid.goal_endings import Decision, End, Ending, carry_out, judge, or_abort
from humanoid.model import JOINT_BY_NAME, MOVING_SPEED
from humanoid.walking.fall_listener import FallListener

NEWER = 'Pre-empted by a newer goal'
STALLED_AFTER = 0.3  # s: fingers that stand still so long before their target have gripped something
STALLED_FOR = 15  # joint states without motion that a grip needs, too: a delayed server has received few
FINGERS = 2  # each of the two fingers moves by half the gap


@dataclass
class Run:
    """One accepted goal in execution. A tick makes its `decision`; `code` is its result's error code."""

    goal: ServerGoalHandle
    decision: Decision = field(default_factory=Decision)
    code: int = FollowJointTrajectory.Result.INVALID_GOAL
    following: Following | None = None
    target: float = 0.0  # m: the target position of one finger
    moved: float = 0.0  # s of the node's clock: when the joint states last showed motion
    sights: int = 0  # how many joint states had arrived when they last showed motion
    stalled: bool = False


class Controller:
    """Executes one goal at a time for its own joints; its subclasses say how the joints move."""

    def __init__(
        self, node: Node, limbs: Limbs, stop: StopListener, fall: FallListener, joints: Sequence[str]
    ) -> None:
        self.joints = joints
        self._node, self._limbs, self._stop, self._fall = node, limbs, stop, fall
        self._runs: dict[bytes, Run] = {}
        self._running: Run | None = None
        self._server: ActionServer | None = None

    def offer(self, type_: type[Any], name: str) -> None:
        self._server = ActionServer(
            self._node,
            type_,
            name,
            execute_callback=self._execute,
            goal_callback=self._judge,
            callback_group=ReentrantCallbackGroup(),  # `_judge` may wait for other callbacks
            handle_accepted_callback=self._accept,
            cancel_callback=lambda _: CancelResponse.ACCEPT,
        )

    def destroy(self) -> None:
        if self._server is not None:
            self._server.destroy()

    @property
    def busy(self) -> bool:
        return self._running is not None

    def tick(self) -> None:
        run = self._running
        if run is None:
            return
        with or_abort(self._node, self.end):
            self._follow_up(run)
            if run is self._running and run.goal.is_cancel_requested:
                self.end(Ending(End.CANCELED, 'Goal canceled'))

    def end(self, ending: Ending) -> None:
        """Decide how the running goal, if any, ends; unless the goal succeeded, its joints hold."""
        run, self._running = self._running, None
        if run is not None:
            self._limbs.release(self.joints)
            run.decision.make(ending)
            if not ending.success:
                self._limbs.command(self.joints)

    async def _judge(self, goal: Any) -> GoalResponse:
        await self._stop.until_known()
        taken = self._limbs.taken - set(self.joints) if self.busy else self._limbs.taken
        return judge(
            self._node, lambda: self._stop.refusal or self._fall.refusal or self._refusal(goal, taken)
        )

    def _accept(self, handle: ServerGoalHandle) -> None:
        """Begin a goal, and abort the running one: it is older, as goals begin in the order of acceptance."""
        self.end(Ending(End.ABORTED, NEWER))
        moment = now(self._node)
        run = self._runs[bytes(handle.goal_id.uuid)] = self._running = Run(handle)
        self._limbs.take(self.joints)
        with or_abort(self._node, self.end):
            self._begin(run, moment)
        if self._stop.stopped:  # the emergency stop came between the goal's acceptance and its start
            self.end(Ending(End.ABORTED, self._stop.ended))
        handle.execute()

    async def _execute(self, handle: ServerGoalHandle) -> object:
        run, ending = await carry_out(self._node, handle, self._runs)
        return self._result(run, ending)

    def _refusal(self, goal: Any, taken: set[str]) -> str | None:
        raise NotImplementedError

    def _begin(self, run: Run, moment: float) -> None:
        raise NotImplementedError

    def _follow_up(self, run: Run) -> None:
        raise NotImplementedError

    def _result(self, run: Run, ending: Ending) -> object:
        raise NotImplementedError


class TrajectoryController(Controller):
    """Serves FollowJointTrajectory. A goal must name all joints of the controller."""

    def _refusal(self, goal: FollowJointTrajectory.Goal, taken: set[str]) -> str | None:
        return refusal(goal, ours=self.joints, here=self._limbs.here, busy=taken, now=now(self._node))

    def _begin(self, run: Run, moment: float) -> None:
        run.following = Following(run.goal.request, self._limbs.samples(self.joints), moment)
        self._limbs.send(run.goal.request.trajectory)

    def _follow_up(self, run: Run) -> None:
        following, limbs = run.following, self._limbs
        assert following is not None
        feedback = FollowJointTrajectory.Feedback()
        feedback.header.stamp = stamp(self._node)
        feedback.joint_names = following.names
        wanted, there = following.desired(limbs.measured), limbs.samples(following.names)
        elapsed = duration_msg(max(limbs.measured - following.begins, 0.0))
        for point in (feedback.desired, feedback.actual, feedback.error):
            point.time_from_start = elapsed
        for name in following.names:
            (position, velocity), actual = wanted[name], there[name]
            feedback.desired.positions.append(position)
            feedback.desired.velocities.append(velocity)
            feedback.actual.positions.append(actual.position)
            feedback.actual.velocities.append(actual.velocity)
            feedback.error.positions.append(position - actual.position)
            feedback.error.velocities.append(velocity - actual.velocity)
        run.goal.publish_feedback(feedback)
        if limbs.are_lost:
            verdict: Verdict | None = Verdict(FollowJointTrajectory.Result.PATH_TOLERANCE_VIOLATED, LOST)
        else:
            verdict = following.verdict(there, limbs.measured, limbs.seen)
        if verdict is not None:
            run.code = verdict.code
            done = verdict.code == FollowJointTrajectory.Result.SUCCESSFUL
            self.end(Ending(End.SUCCEEDED if done else End.ABORTED, verdict.message))

    def _result(self, run: Run, ending: Ending) -> FollowJointTrajectory.Result:
        """Return the result; it is empty for a cancelled goal, as in ROS 2's joint_trajectory_controller."""
        if ending.end is End.CANCELED:
            return FollowJointTrajectory.Result()
        return FollowJointTrajectory.Result(error_code=run.code, error_string=ending.message)


class GripperController(Controller):
    """Serves GripperCommand: a goal is the gap between two fingers, in m. Gripping an object succeeds."""

    @property
    def _joint(self) -> str:
        return self.joints[0]

    def _refusal(self, goal: GripperCommand.Goal, taken: set[str]) -> str | None:
        gap, effort, spec = goal.command.position, goal.command.max_effort, JOINT_BY_NAME[self._joint]
        if not spec.lower * FINGERS <= gap <= spec.upper * FINGERS:  # NaN included
            return f'a gap of {gap} m is not one from {spec.lower * FINGERS} to {spec.upper * FINGERS} m'
        if not 0.0 <= effort <= math.inf:
            return f'max_effort {effort} N is not a force'
        if self._joint in taken:
            return f'{self._joint} is moving for another goal; cancel that one first'
        if self._joint not in self._limbs.here:
            return f'nothing is known of {self._joint} yet: no joint state has shown it'
        return None

    def _begin(self, run: Run, moment: float) -> None:
        command, spec = run.goal.request.command, JOINT_BY_NAME[self._joint]
        run.target, run.moved, run.sights = command.position / FINGERS, moment, self._limbs.sights
        way = abs(run.target - self._limbs.here[self._joint])
        trajectory = [JointTrajectoryPoint(positions=[run.target])]
        trajectory[0].time_from_start = duration_msg(max(way / spec.max_velocity, 0.02))
        if command.max_effort > 0.0:
            trajectory[0].effort = [min(command.max_effort, spec.max_effort)]
        self._limbs.send(JointTrajectory(joint_names=[self._joint], points=trajectory))

    def _follow_up(self, run: Run) -> None:
        limbs, spec, moment = self._limbs, JOINT_BY_NAME[self._joint], now(self._node)
        if abs(limbs.speeds.get(self._joint, 0.0)) > MOVING_SPEED:
            run.moved, run.sights = moment, limbs.sights
        reached = abs(limbs.here[self._joint] - run.target) <= spec.arrived_within
        still = moment - run.moved > STALLED_AFTER and limbs.sights - run.sights >= STALLED_FOR
        run.stalled = still and not reached
        feedback = GripperCommand.Feedback(reached_goal=reached, stalled=run.stalled)
        feedback.position, feedback.effort = self._gap(), limbs.efforts.get(self._joint, 0.0)
        run.goal.publish_feedback(feedback)
        if limbs.are_lost:
            self.end(Ending(End.ABORTED, LOST))
        elif reached:
            self.end(Ending(End.SUCCEEDED, f'{self._joint} is {self._gap():.3f} m open'))
        elif run.stalled:
            self.end(Ending(End.SUCCEEDED, f'{self._joint} met something at {self._gap():.3f} m'))

    def _gap(self) -> float:
        return self._limbs.here[self._joint] * FINGERS

    def _result(self, run: Run, ending: Ending) -> GripperCommand.Result:
        """Return the result; it is empty for a cancelled goal, as in ROS 2's GripperActionController."""
        if ending.end is End.CANCELED:
            return GripperCommand.Result()
        return GripperCommand.Result(
            position=self._gap(),
            effort=self._limbs.efforts.get(self._joint, 0.0),
            stalled=run.stalled,
            reached_goal=ending.success and not run.stalled,
        )
