"""arm_action_server: the action `move_arm` moves joints by `joint_command` and watches `joint_states`.

The node also serves the controllers of arms and hands, `wave` and `stand`, each on joints that are free.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from functools import partial
from uuid import uuid4

from control_msgs.action import FollowJointTrajectory, GripperCommand
from diagnostic_msgs.msg import DiagnosticStatus
from humanoid_interfaces.action import MoveArm
from rclpy.action import ActionServer, CancelResponse, GoalResponse
from rclpy.action.server import ServerGoalHandle
from rclpy.callback_groups import ReentrantCallbackGroup
from rclpy.node import Node
from std_msgs.msg import String
from std_srvs.srv import Trigger

from humanoid.arm.controllers import Controller, GripperController, TrajectoryController
from humanoid.arm.goal_check import refusal
from humanoid.arm.limbs import LOST, TICK, Limbs
from humanoid.arm.motion import ArmMotion
from humanoid.clock import now
from humanoid.diagnostics import Diagnostics, Health
from humanoid.emergency.listener import StopListener
from humanoid.emergency.names import make_latched_qos
from humanoid.gestures import STAND, WAVE, Movement, time_unhurried
from humanoid.goal_endings import Decision, End, Ending, carry_out, judge, or_abort
from humanoid.model import JOINT_BY_NAME
from humanoid.running import run
from humanoid.walking.fall_listener import FallListener
from humanoid.walking.names import BALANCES, BALANCING, FELL


@dataclass
class Reach:
    """One motion in execution: of an accepted goal, or of a gesture (`wave`, `stand`), which has no goal."""

    goal: ServerGoalHandle | None
    names: Sequence[str]
    motion: ArmMotion = field(init=False)
    decision: Decision = field(default_factory=Decision)


class ArmActionServer(Node):
    """Executes any number of goals at once, as long as no two of them share a joint."""

    def __init__(self) -> None:
        super().__init__('arm_action_server')
        self._reaches: dict[bytes, Reach] = {}
        self._limbs = Limbs(self, self._see)
        self._stop = StopListener(self, self._emergency)
        self._fall = FallListener(self, partial(self._end_all, FELL))
        self._diagnostics = Diagnostics(self, 'arms', self._health)
        self._balancing: frozenset[str] = frozenset()  # joints that a walking robot needs for its balance
        self.create_subscription(String, BALANCING, self._learn, make_latched_qos())
        self._controllers: dict[str, Controller] = {}
        for side in ('left', 'right'):
            arm = [name for name in JOINT_BY_NAME if name.startswith(f'{side}_arm_')]
            trajectories = TrajectoryController(self, self._limbs, self._stop, self._fall, arm)
            gripper = GripperController(self, self._limbs, self._stop, self._fall, [f'{side}_gripper'])
            self._controllers[f'{side}_arm_controller/follow_joint_trajectory'] = trajectories
            self._controllers[f'{side}_gripper_controller/gripper_cmd'] = gripper
        self.create_timer(TICK, self._tick)
        self._action_server: ActionServer | None = None
        self.get_logger().info('Arm Action Server waiting for joint states')

    def destroy_node(self) -> None:
        if self._action_server is not None:
            self._action_server.destroy()
        for controller in self._controllers.values():
            controller.destroy()
        super().destroy_node()

    def _see(self) -> None:
        """Offer the actions once joint states and the emergency stop's state are known: goals need both."""
        if self._action_server is not None or not self._stop.has_heard:
            return
        self._action_server = ActionServer(
            self,
            MoveArm,
            'move_arm',
            execute_callback=self._execute,
            goal_callback=self._judge,
            callback_group=ReentrantCallbackGroup(),  # `_judge` may wait for other callbacks
            handle_accepted_callback=self._begin,
            cancel_callback=self._cancel,
        )
        for name, controller in self._controllers.items():
            grips = isinstance(controller, GripperController)
            controller.offer(GripperCommand if grips else FollowJointTrajectory, name)
        waiting = ReentrantCallbackGroup()  # the callbacks of these services wait until the joints have moved
        self.create_service(Trigger, 'wave', self._wave, callback_group=waiting)
        self.create_service(Trigger, 'stand', self._stand, callback_group=waiting)
        self.get_logger().info('Arm Action Server ready')

    async def _judge(self, goal: MoveArm.Goal) -> GoalResponse:
        await self._stop.until_known()
        response = judge(self, lambda: self._refusal(goal.joint_names, goal.positions, goal.duration))
        if response is GoalResponse.ACCEPT:
            self.get_logger().info(f'Goal accepted: {", ".join(goal.joint_names)}')
        return response

    def _begin(self, goal_handle: ServerGoalHandle) -> None:
        goal = goal_handle.request
        reach = self._reaches[bytes(goal_handle.goal_id.uuid)] = Reach(goal_handle, list(goal.joint_names))
        self._start(reach, list(goal.positions), goal.duration)
        goal_handle.execute()

    def _refusal(self, names: Sequence[str], positions: Sequence[float], duration: float) -> str | None:
        if reason := self._stop.refusal:
            return reason
        if reason := self._fall.refusal:
            return reason
        if legs := [name for name in names if name in self._balancing]:
            return f'{legs[0]} {BALANCES}'
        limbs = self._limbs
        return refusal(names, positions, duration, here=limbs.here, busy=limbs.taken, joints=JOINT_BY_NAME)

    def _start(self, reach: Reach, target: Sequence[float], duration: float) -> None:
        self._limbs.take(reach.names)
        with or_abort(self, partial(self._end, reach)):
            start = [self._limbs.here[name] for name in reach.names]
            reach.motion = ArmMotion(reach.names, start, target, duration, now(self))
            self._command(reach.names, reach.motion.target, reach.motion.duration)
        if self._stop.stopped and not reach.decision.made:  # the emergency stop came meanwhile
            self._end(reach, Ending(End.ABORTED, self._stop.ended))

    async def _wave(self, _request: Trigger.Request, response: Trigger.Response) -> Trigger.Response:
        return await self._perform('waved', WAVE, response)

    async def _stand(self, _request: Trigger.Request, response: Trigger.Response) -> Trigger.Response:
        return await self._perform('standing', STAND, response)

    async def _perform(
        self, done: str, movements: Sequence[Movement], response: Trigger.Response
    ) -> Trigger.Response:
        """Make a gesture's movements in turn; respond after the last one, or after the first that fails."""
        response.success, response.message = True, done
        for movement in movements:
            ending = await self._make(movement)
            if not ending.success:
                response.success, response.message = False, ending.message
                break
        self.get_logger().info(response.message)
        return response

    async def _make(self, movement: Movement) -> Ending:
        movement = {name: angle for name, angle in movement.items() if name not in self._balancing}
        names, target = list(movement), list(movement.values())
        unseen = [name for name in names if name not in self._limbs.here]
        duration = 1.0 if unseen else time_unhurried(movement, self._limbs.here)
        if reason := self._refusal(names, target, duration):
            return Ending(End.ABORTED, reason)
        key, reach = uuid4().bytes, Reach(None, names)
        self._reaches[key] = reach
        self._start(reach, target, duration)
        try:
            return await reach.decision.wait()
        finally:
            del self._reaches[key]

    def _emergency(self) -> None:
        self._end_all(self._stop.ended)

    def _learn(self, told: String) -> None:
        self._balancing = frozenset(told.data.split(','))

    def _end_all(self, reason: str) -> None:
        ending = Ending(End.ABORTED, reason)
        for reach in self._reaches.values():
            if not reach.decision.made:
                self._end(reach, ending)
        for controller in self._controllers.values():
            controller.end(ending)

    def _health(self) -> Health:
        limbs = self._limbs
        values = {'joints seen': len(limbs.here), 'joints taken': len(limbs.taken)}
        if limbs.are_lost:
            return Health('no joint states', DiagnosticStatus.STALE, values)
        if self._stop.stopped:
            return Health(self._stop.ended.lower(), DiagnosticStatus.WARN, values)
        return Health('moving' if limbs.taken else 'still', values=values)

    def _cancel(self, _goal_handle: ServerGoalHandle) -> CancelResponse:
        self.get_logger().info('Received cancel request')
        return CancelResponse.ACCEPT

    async def _execute(self, goal_handle: ServerGoalHandle) -> MoveArm.Result:
        reach, ending = await carry_out(self, goal_handle, self._reaches)
        result = MoveArm.Result()
        result.final_positions = [self._limbs.here[name] for name in reach.names]
        result.success, result.message = ending.success, ending.message
        return result

    def _tick(self) -> None:
        self._limbs.look()
        for reach in self._reaches.values():
            if not reach.decision.made:
                with or_abort(self, partial(self._end, reach)):
                    self._follow_up(reach)
        for controller in self._controllers.values():
            controller.tick()

    def _follow_up(self, reach: Reach) -> None:
        motion, here = reach.motion, self._limbs.here
        if reach.goal is not None:
            feedback = MoveArm.Feedback()
            feedback.joint_names = list(motion.names)
            feedback.positions = [here[name] for name in motion.names]
            feedback.fraction_done = motion.fraction_done(here)
            reach.goal.publish_feedback(feedback)
        if reach.goal is not None and reach.goal.is_cancel_requested:
            self._end(reach, Ending(End.CANCELED, 'Goal canceled'))
        elif motion.arrived(here):
            self._end(reach, Ending(End.SUCCEEDED, 'Arm motion completed successfully'))
        elif self._limbs.are_lost:
            self._end(reach, Ending(End.ABORTED, LOST))
        elif failure := motion.failure(here, self._limbs.seen):
            self._end(reach, Ending(End.ABORTED, failure))

    def _end(self, reach: Reach, ending: Ending) -> None:
        self._limbs.release(reach.names)
        reach.decision.make(ending)
        if not ending.success:
            self._command(reach.names)

    def _command(self, names: Sequence[str], target: Sequence[float] = (), duration: float = 0.0) -> None:
        """Command the joints to reach `target` in `duration` seconds; without a target the joints hold."""
        self._limbs.command(names, target, duration)


def main(args: Sequence[str] | None = None) -> int:
    return run(ArmActionServer, args)


if __name__ == '__main__':
    raise SystemExit(main())
