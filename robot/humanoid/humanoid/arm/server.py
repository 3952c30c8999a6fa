"""arm_action_server: `move_arm` commands `joint_command` and sees them arrive in `joint_states`."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field
from functools import partial

from humanoid_interfaces.action import MoveArm
from rclpy.action import ActionServer, CancelResponse, GoalResponse
from rclpy.action.server import ServerGoalHandle
from rclpy.node import Node
from sensor_msgs.msg import JointState
from trajectory_msgs.msg import JointTrajectory, JointTrajectoryPoint

from humanoid.arm.goal_check import refusal
from humanoid.arm.motion import ArmMotion
from humanoid.clock import duration_msg, now
from humanoid.endings import Decision, End, Ending, judged, or_abort, settle
from humanoid.model import JOINT_BY_NAME
from humanoid.running import run

TICK = 0.05  # s: looks at the joints and gives feedback at 20 Hz


@dataclass
class Reach:
    """One accepted goal on its way."""

    goal: ServerGoalHandle
    names: Sequence[str]
    motion: ArmMotion = field(init=False)
    decision: Decision = field(default_factory=Decision)


class ArmActionServer(Node):
    """Moves any number of goals at once, as long as no two of them share a joint."""

    def __init__(self) -> None:
        super().__init__('arm_action_server')
        self._here: dict[str, float] = {}
        self._seen = 0.0
        self._reaches: dict[bytes, Reach] = {}
        self._claimed: set[str] = set()
        self._commands = self.create_publisher(JointTrajectory, 'joint_command', 10)
        self.create_subscription(JointState, 'joint_states', self._see, 10)
        self.create_timer(TICK, self._tick)
        self._action_server: ActionServer | None = None
        self.get_logger().info('Arm Action Server waiting for joint states')

    def destroy_node(self) -> None:
        if self._action_server is not None:
            self._action_server.destroy()
        super().destroy_node()

    def _see(self, states: JointState) -> None:
        """Joint states need not name every joint; what is no angle of ours (NaN, a tail) is not seen."""
        seen = {
            name: position
            for name, position in zip(states.name, states.position, strict=False)
            if name in JOINT_BY_NAME and math.isfinite(position)
        }
        if not seen:
            return
        self._here.update(seen)
        self._seen = now(self)
        if self._action_server is None:
            self._offer()

    def _offer(self) -> None:
        """Only a server that knows where the joints are appears as one: clients then need not guess."""
        self._action_server = ActionServer(
            self,
            MoveArm,
            'move_arm',
            execute_callback=self._execute,
            goal_callback=self._judge,
            handle_accepted_callback=self._begin,
            cancel_callback=self._cancel,
        )
        self.get_logger().info('Arm Action Server ready')

    def _judge(self, goal: MoveArm.Goal) -> GoalResponse:
        check = partial(refusal, here=self._here, busy=self._claimed, joints=JOINT_BY_NAME)
        response = judged(self, lambda: check(goal.joint_names, goal.positions, goal.duration))
        if response is GoalResponse.ACCEPT:
            self.get_logger().info(f'Goal accepted: {", ".join(goal.joint_names)}')
        return response

    def _begin(self, goal_handle: ServerGoalHandle) -> None:
        goal = goal_handle.request
        reach = self._reaches[bytes(goal_handle.goal_id.uuid)] = Reach(goal_handle, list(goal.joint_names))
        self._claimed.update(reach.names)
        with or_abort(self, partial(self._end, reach)):
            start = [self._here[name] for name in reach.names]
            reach.motion = ArmMotion(reach.names, start, list(goal.positions), goal.duration, now(self))
            self._command(reach.names, reach.motion.target, reach.motion.duration)
        goal_handle.execute()

    def _cancel(self, _goal_handle: ServerGoalHandle) -> CancelResponse:
        self.get_logger().info('Received cancel request')
        return CancelResponse.ACCEPT

    async def _execute(self, goal_handle: ServerGoalHandle) -> MoveArm.Result:
        key = bytes(goal_handle.goal_id.uuid)
        reach = self._reaches[key]
        try:
            ending = await reach.decision.wait()
        finally:
            del self._reaches[key]
        settle(goal_handle, ending)
        self.get_logger().info(ending.message)
        result = MoveArm.Result()
        result.final_positions = [self._here[name] for name in reach.names]
        result.success, result.message = ending.success, ending.message
        return result

    def _tick(self) -> None:
        moment = now(self)
        for reach in self._reaches.values():
            if not reach.decision.made:
                with or_abort(self, partial(self._end, reach)):
                    self._follow_up(reach, moment)

    def _follow_up(self, reach: Reach, moment: float) -> None:
        motion = reach.motion
        feedback = MoveArm.Feedback()
        feedback.joint_names = list(motion.names)
        feedback.positions = [self._here[name] for name in motion.names]
        feedback.fraction_done = motion.fraction_done(self._here)
        reach.goal.publish_feedback(feedback)
        if reach.goal.is_cancel_requested:
            self._end(reach, Ending(End.CANCELED, 'Goal canceled'))
        elif motion.arrived(self._here):
            self._end(reach, Ending(End.SUCCEEDED, 'Arm motion completed successfully'))
        elif failure := motion.failure(self._here, self._seen, moment):
            self._end(reach, Ending(End.ABORTED, failure))

    def _end(self, reach: Reach, ending: Ending) -> None:
        self._claimed.difference_update(reach.names)
        reach.decision.make(ending)
        if not ending.success:
            self._command(reach.names)

    def _command(self, names: Sequence[str], target: Sequence[float] = (), duration: float = 0.0) -> None:
        """Send the joints to `target` in `duration` seconds; without a target they hold still."""
        command = JointTrajectory(joint_names=list(names))
        if target:
            point = JointTrajectoryPoint(positions=list(target))
            point.time_from_start = duration_msg(duration)
            command.points.append(point)
        self._commands.publish(command)


def main(args: Sequence[str] | None = None) -> int:
    return run(ArmActionServer, args)


if __name__ == '__main__':
    raise SystemExit(main())
