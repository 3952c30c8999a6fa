"""navigation_action_server: `move_to_position` and `cmd_vel` drive the base, `odom` reports its pose.

One control timer moves the base and decides how a goal ends; the goal's coroutine only waits for that
decision. Everything runs on the executor's one thread, so nothing here needs a lock.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING

from diagnostic_msgs.msg import DiagnosticStatus
from geometry_msgs.msg import Twist
from humanoid_interfaces.action import MoveToPosition
from nav_msgs.msg import Odometry
from rclpy.action import ActionServer, CancelResponse, GoalResponse
from rclpy.action.server import ServerGoalHandle
from rclpy.callback_groups import ReentrantCallbackGroup
from rclpy.node import Node
from rclpy.qos import qos_profile_sensor_data
from sensor_msgs.msg import Imu
from tf2_ros import StaticTransformBroadcaster, TransformBroadcaster

from humanoid.clock import now, seconds, stamp
from humanoid.diagnostics import Diagnostics, Health
from humanoid.emergency.listener import StopListener
from humanoid.goal_endings import Decision, End, Ending, carry_out, judge, or_abort
from humanoid.navigation.base import (
    STANDING,
    VELOCITY_LASTS,
    Base,
    LimitedBase,
    MobileBase,
    Pose2D,
    SimulatedBase,
    Velocity2D,
)
from humanoid.navigation.drift import DRIFT, Drift, DriftSpec
from humanoid.navigation.goal_check import FARTHEST, FRAME, refusal
from humanoid.navigation.messages import imu, odometry, place_frame, stamp_pose, target_of, transform
from humanoid.navigation.truth import TruthTeller
from humanoid.running import BadParameter, check_range, run

if TYPE_CHECKING:
    from humanoid.navigation.in_world import Surroundings

TICK = 0.02  # s between control steps: 50 Hz
FEEDBACK_EVERY = 0.1  # s: 10 Hz
NOTICED = 0.005  # m/s or rad/s: a smaller reduction of a cmd_vel is not reported
MEANT = {
    'place': 'x, y and yaw',
    'odometry_drift': 'shares of the way and of turns, and rad a metre',
}


@dataclass
class Drive:
    """One accepted goal, until it has ended."""

    goal: ServerGoalHandle
    began: float
    next_feedback: float
    target: Pose2D = field(default_factory=Pose2D)
    stopped_at: Pose2D = field(default_factory=Pose2D)
    decision: Decision = field(default_factory=Decision)

    @property
    def timeout(self) -> float:
        return float(self.goal.request.timeout)


class NavigationActionServer(Node):
    """Drives to one goal at a time; a newer goal pre-empts the older one, which ends ABORTED.

    Pass a MobileBase to drive a real base. In a world the navigator serves the goals, and this node obeys the
    navigator's `cmd_vel_nav`; a guard keeps the base away from what the scanner sees.
    """

    def __init__(self, base: MobileBase | None = None) -> None:
        super().__init__('navigation_action_server')
        self._prefix = self.declare_parameter('frame_prefix', '').get_parameter_value().string_value
        self._base: MobileBase = base or Base()
        self._drives: dict[bytes, Drive] = {}
        self._driving: Drive | None = None
        self._stepped = now(self)
        self._by_hand: float | None = None  # when cmd_vel, not cmd_vel_nav, last asked for motion
        self._told: float | None = None  # when the last velocity arrived; None if none drives the base
        self._velocity = self._wish = STANDING  # velocity at the last tick; requested velocity
        self._odometry = self.create_publisher(Odometry, 'odom', 10)
        self._transforms = TransformBroadcaster(self)
        self._map = self._publish_place()
        world = self.declare_parameter('world', '').get_parameter_value().string_value
        self._surroundings = _surroundings(self) if world else None
        # Without a world and without physics, odometry is exact, so no `ground_truth` is published.
        self._truth: TruthTeller | None = None
        if isinstance(self._base, SimulatedBase) and (world or base is not None):
            self._truth = TruthTeller(self, self._base, self._prefix)
        drift = self._three('odometry_drift', DRIFT if world and base is None else [0.0, 0.0, 0.0], 1.0)
        self._drift = Drift(DriftSpec(*drift), self._base.pose)
        # A base that is passed in (physics, hardware) publishes its own `imu`.
        self._imu = self.create_publisher(Imu, 'imu', qos_profile_sensor_data) if base is None else None
        self._stop = StopListener(self, self._emergency)
        self._diagnostics = Diagnostics(self, 'base', self._health)
        self.create_subscription(Twist, 'cmd_vel', self._obey_hand, 10)
        self.create_timer(TICK, self._tick)
        self._action_server: ActionServer | None = None
        if self._surroundings is None:  # in a world the navigator serves the action
            self.get_logger().info('Navigation Action Server waiting for the emergency stop')
        else:
            self.create_subscription(Twist, 'cmd_vel_nav', self._follow, 10)
            self.get_logger().info('Navigation Action Server ready')

    def _offer(self) -> None:
        """Offer the action once the emergency stop's state is known: before that, goals would be refused."""
        if self._surroundings is not None or self._action_server is not None or not self._stop.has_heard:
            return
        self._action_server = ActionServer(
            self,
            MoveToPosition,
            'move_to_position',
            execute_callback=self._execute,
            goal_callback=self._judge,
            callback_group=ReentrantCallbackGroup(),  # `_judge` may wait for other callbacks
            handle_accepted_callback=self._begin,
            cancel_callback=self._cancel,
        )
        self.get_logger().info('Navigation Action Server ready')

    def _three(self, name: str, default: Sequence[float], most: float) -> Sequence[float]:
        """Read a parameter that has three numbers. Raises BadParameter."""
        numbers = self.declare_parameter(name, list(default)).get_parameter_value().double_array_value
        if len(numbers) != 3:
            raise BadParameter(f'the parameter {name} has {len(numbers)} numbers, not 3: {MEANT[name]}')
        for number in numbers:
            check_range(name, number, -most, most)
        return numbers

    def _publish_place(self) -> StaticTransformBroadcaster | None:
        """Publish the pose of `odom` in `map_frame`, if that is set: the robots of a fleet stand apart."""
        frame = self.declare_parameter('map_frame', '').get_parameter_value().string_value
        place = Pose2D(*self._three('place', [0.0, 0.0, 0.0], FARTHEST))
        if not frame:
            return None
        broadcaster = StaticTransformBroadcaster(self)
        broadcaster.sendTransform(place_frame(frame, place, stamp(self), f'{self._prefix}{FRAME}'))
        return broadcaster

    def destroy_node(self) -> None:
        if self._action_server is not None:
            self._action_server.destroy()
        super().destroy_node()

    async def _judge(self, goal: MoveToPosition.Goal) -> GoalResponse:
        await self._stop.until_known()
        pose = goal.target_pose.pose
        position = (pose.position.x, pose.position.y, pose.position.z)
        turn = pose.orientation
        orientation = (turn.x, turn.y, turn.z, turn.w)
        frame = goal.target_pose.header.frame_id.removeprefix(self._prefix)
        response = judge(
            self,
            lambda: self._stop.refusal or refusal(frame, position, orientation, goal.timeout),
        )
        if response is GoalResponse.ACCEPT:
            self.get_logger().info(f'Goal accepted: ({position[0]:.2f}, {position[1]:.2f}) m')
        return response

    def _begin(self, goal_handle: ServerGoalHandle) -> None:
        """Begin a goal, and abort the running one: it is older, as goals begin in the order of acceptance."""
        self._end(Ending(End.ABORTED, 'Pre-empted by a newer goal'))
        moment = now(self)
        drive = Drive(goal_handle, moment, moment)
        self._told = None
        self._drives[bytes(goal_handle.goal_id.uuid)] = self._driving = drive
        self._stepped = moment  # the next step must not count the time before this goal
        with or_abort(self, self._end):
            drive.target = target_of(goal_handle.request.target_pose.pose)
            self._base.drive_to(drive.target)
        if self._stop.stopped:  # the emergency stop came between the goal's acceptance and its start
            self._end(Ending(End.ABORTED, self._stop.ended))
        goal_handle.execute()

    def _obey_hand(self, command: Twist) -> None:
        """Obey a person's cmd_vel; a command of zero does not interrupt the navigator."""
        if command.linear.x or command.linear.y or command.angular.z:
            self._by_hand = now(self)
        elif self._surroundings is not None and not self._is_by_hand():
            return
        if self._obey(command) and (text := _beyond_limits(self._base, self._wish)):
            self.get_logger().warning(text, throttle_duration_sec=5.0)

    def _is_by_hand(self) -> bool:
        return self._by_hand is not None and now(self) - self._by_hand <= VELOCITY_LASTS

    def _obey(self, command: Twist) -> bool:
        """Move at the command's velocity; return False if the command is ignored.

        A velocity other than zero aborts the running goal.
        """
        wish = Velocity2D(command.linear.x, command.linear.y, command.angular.z)
        log = self.get_logger()
        if reason := self._stop.refusal:
            log.warning(f'Ignored cmd_vel: {reason}', throttle_duration_sec=1.0)
            return False
        if not all(map(math.isfinite, (wish.x, wish.y, wish.yaw))):
            log.warning(f'Ignored cmd_vel: {wish} is not finite', throttle_duration_sec=1.0)
            return False
        if self._driving is not None and wish == STANDING:
            return False
        self._end(Ending(End.ABORTED, 'Pre-empted by cmd_vel'))
        self._wish, self._told = wish, now(self)
        self._drive_on()
        return True

    def _follow(self, command: Twist) -> None:
        """Obey the navigator's cmd_vel_nav, unless a person's cmd_vel has taken over."""
        if not self._is_by_hand():
            self._obey(command)

    def _drive_on(self) -> None:
        """Move at the requested velocity, limited by the obstacles around."""
        wish = self._wish
        if self._surroundings is not None:
            wish = self._surroundings.limit(wish, self._base.pose)
        self._base.drive_at(wish)

    def _emergency(self) -> None:
        self._told = None
        self._base.stop()
        self._end(Ending(End.ABORTED, self._stop.ended))

    def _health(self) -> Health:
        pose, doing = self._base.pose, 'standing'
        if self._driving is not None:
            doing = 'driving to a goal'
        elif self._told is not None:
            doing = 'driving by cmd_vel'
        values = {'x': f'{pose.x:.3f}', 'y': f'{pose.y:.3f}', 'yaw': f'{pose.yaw:.3f}'}
        if self._stop.stopped:
            return Health(self._stop.ended.lower(), DiagnosticStatus.WARN, values)
        return Health(doing, values=values)

    def _cancel(self, _goal_handle: ServerGoalHandle) -> CancelResponse:
        self.get_logger().info('Received cancel request')
        return CancelResponse.ACCEPT

    async def _execute(self, goal_handle: ServerGoalHandle) -> MoveToPosition.Result:
        drive, ending = await carry_out(self, goal_handle, self._drives)
        result = MoveToPosition.Result()
        result.success, result.message = ending.success, ending.message
        result.final_pose = stamp_pose(drive.stopped_at, stamp(self), self._prefix)
        return result

    def _tick(self) -> None:
        moment = now(self)
        self._offer()
        if self._driving is not None and self._driving.goal.is_cancel_requested:
            self._end(Ending(End.CANCELED, 'Goal canceled'))
        if self._told is not None and not 0.0 <= moment - self._told <= VELOCITY_LASTS:
            self._told = None
            self._base.stop()
            if self._wish != STANDING:  # the sender of velocities fell silent while the base moved
                self.get_logger().warning(f'Stopped: no newer velocity came for {VELOCITY_LASTS:g} s')
        elif self._told is not None and self._surroundings is not None:
            self._drive_on()
        with or_abort(self, self._end):
            self._base.step(moment - self._stepped)
            if self._driving is not None:
                self._follow_up(self._driving, moment)
        elapsed, self._stepped = moment - self._stepped, moment
        counted, frame = self._drift.follow(self._base.pose), f'{self._prefix}{FRAME}'
        told = odometry(self._base, counted, frame, stamp(self), self._prefix)
        if self._surroundings is not None:
            self._surroundings.note_pose(seconds(told.header.stamp), self._base.pose)
        if self._truth is not None:
            self._truth.tell(told.header.stamp)
        self._odometry.publish(told)
        self._transforms.sendTransform(transform(told))
        before, self._velocity = self._velocity, self._base.velocity
        if self._imu is not None:
            pose = self._base.pose
            self._imu.publish(imu(pose, before, self._velocity, elapsed, told.header.stamp, self._prefix))

    def _follow_up(self, drive: Drive, moment: float) -> None:
        elapsed = moment - drive.began
        if moment >= drive.next_feedback:
            drive.next_feedback += FEEDBACK_EVERY
            feedback = MoveToPosition.Feedback()
            feedback.current_pose = stamp_pose(self._base.pose, stamp(self), self._prefix)
            feedback.elapsed_time = elapsed
            feedback.distance_remaining = self._base.distance_to(drive.target)
            drive.goal.publish_feedback(feedback)
        if self._base.arrived:
            self._end(Ending(End.SUCCEEDED, 'Navigation completed successfully'))
        elif elapsed >= drive.timeout:
            left = self._base.distance_to(drive.target)
            message = f'Timed out after {drive.timeout:g} s, {left:.2f} m short of the target'
            self._end(Ending(End.ABORTED, message))

    def _end(self, ending: Ending) -> None:
        """If a goal is running, stop the base and decide how the goal ends."""
        drive, self._driving = self._driving, None
        if drive is not None:
            self._base.stop()
            drive.stopped_at = self._base.pose
            drive.decision.make(ending)


def _surroundings(node: Node) -> Surroundings:
    from humanoid.navigation.in_world import Surroundings  # needs numpy, which only worlds require

    return Surroundings(node)


def _beyond_limits(base: MobileBase, wish: Velocity2D) -> str:
    """Return a warning for the person who asks for more than the base can do, else ''."""
    moves = base.limit(wish) if isinstance(base, LimitedBase) else wish
    if max(abs(wish.x - moves.x), abs(wish.y - moves.y), abs(wish.yaw - moves.yaw)) <= NOTICED:
        return ''
    return f'cmd_vel asks for more than the base can do: {_in_words(wish)}; it moves at {_in_words(moves)}'


def _in_words(velocity: Velocity2D) -> str:
    return f'{velocity.x:.2f} m/s ahead, {velocity.y:.2f} m/s to the left, {velocity.yaw:.2f} rad/s'


def main(args: Sequence[str] | None = None) -> int:
    return run(NavigationActionServer, args)


if __name__ == '__main__':
    raise SystemExit(main())
