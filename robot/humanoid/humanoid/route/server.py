"""navigator: plans a path through the world, follows it by `cmd_vel_nav`, and serves the navigation actions.

One timer advances the drive and decides how its goal ends; the goal's coroutine only waits for that decision.
Everything runs on the executor's one thread, so nothing here needs a lock.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field
from functools import partial
from typing import Any

import numpy as np
from diagnostic_msgs.msg import DiagnosticStatus
from geometry_msgs.msg import PoseStamped, Twist
from lifecycle_msgs.srv import GetState
from nav2_msgs.action import NavigateToPose
from nav_msgs.msg import OccupancyGrid, Path
from rclpy.action import ActionClient, ActionServer, CancelResponse, GoalResponse
from rclpy.action.server import ServerGoalHandle
from rclpy.callback_groups import ReentrantCallbackGroup
from rclpy.node import Node
from rclpy.qos import qos_profile_sensor_data
from rclpy.task import Future
from sensor_msgs.msg import LaserScan
from std_msgs.msg import Empty
from tf2_ros import Buffer, TransformListener

from humanoid.clock import now, stamp
from humanoid.diagnostics import Diagnostics, Health
from humanoid.emergency.listener import StopListener
from humanoid.emergency.names import make_latched_qos
from humanoid.goal_endings import Decision, End, Ending, carry_out, judge, or_abort
from humanoid.maps import Array, read, write
from humanoid.model import DESCRIPTION
from humanoid.nav2_states import tell_state
from humanoid.navigation.base import STANDING, Pose2D, Velocity2D, compose, invert
from humanoid.route.actions import MANNERS, Manner, Progress
from humanoid.route.costmap import Costmap
from humanoid.route.errand import Errand
from humanoid.route.goals import MAP, Frames, Refused, judge_by
from humanoid.route.messages import path_message, pose_message
from humanoid.route.paths import PathServers
from humanoid.route.task import Task
from humanoid.route.teleop_errand import TeleopErrand
from humanoid.running import run
from humanoid.walking.fall_listener import FallListener
from humanoid.walking.names import FELL, LIES

TICK = 0.05  # s: 20 Hz
FEEDBACK_EVERY = 0.1  # s
SHOW_EVERY = 0.5  # s between two local costmaps; the global costmap is published every fourth time
LOCAL_HALF = 2.0  # m: half the side of the local costmap
LASER = DESCRIPTION.pose('laser', {}).translation


@dataclass
class Drive:
    """One accepted goal, until it has ended."""

    goal: ServerGoalHandle
    manner: Manner
    task: Task
    frame: str  # of the goal
    origin: Pose2D  # the pose of the goal's frame on the map when the goal began
    allowed: float  # s
    next_feedback: float
    shown: Array | None = None  # the path that was published last
    speed: float = 0.0  # m/s that the base was asked for last
    last: Progress | None = None
    decision: Decision = field(default_factory=Decision)


class Navigator(Node):
    """Drives to one goal at a time; a newer goal pre-empts the older one, which ends ABORTED."""

    def __init__(self) -> None:
        super().__init__('navigator')
        self._prefix = self.declare_parameter('frame_prefix', '').get_parameter_value().string_value
        self.declare_parameter('world', '')  # unused here, but passed to all programs of a world
        self._costmap: Costmap | None = None
        self._drives: dict[bytes, Drive] = {}
        self._driving: Drive | None = None
        buffer = Buffer()
        self._listener = TransformListener(buffer, self)
        self._frames = Frames(buffer, self._prefix)
        self._velocity = self.create_publisher(Twist, 'cmd_vel_nav', 10)
        self._plan = self.create_publisher(Path, 'plan', 10)
        self._global = self.create_publisher(OccupancyGrid, 'global_costmap/costmap', make_latched_qos())
        self._local = self.create_publisher(OccupancyGrid, 'local_costmap/costmap', make_latched_qos())
        self._shown = 0
        self._sent: Future[Any] | None = None  # the last goal from the topic goal_pose
        self.create_subscription(OccupancyGrid, 'map', self._take_map, make_latched_qos())
        self.create_subscription(LaserScan, 'scan', self._see, qos_profile_sensor_data)
        self.create_subscription(Twist, 'cmd_vel', self._yield_to, 10)
        self.create_subscription(PoseStamped, 'goal_pose', self._send_goal, 1)
        self.create_subscription(Twist, 'cmd_vel_teleop', self._hear_teleop, 10)
        self.create_subscription(Empty, 'preempt_teleop', self._finish_teleop, 10)
        self._stop = StopListener(self, self._emergency)
        self._fall = FallListener(self, self._fell)
        Diagnostics(self, 'navigation', self._health)
        self._servers: list[ActionServer] = []
        self._own = ActionClient(self, NavigateToPose, 'navigate_to_pose')
        self.create_service(GetState, 'bt_navigator/get_state', self._tell_state)
        self.create_timer(TICK, self._tick)
        self.create_timer(SHOW_EVERY, self._show)

    @property
    def _is_ready(self) -> bool:
        """True if a map and the robot's pose on it are known."""
        return self._costmap is not None and self._frames.robot(now(self)) is not None

    def _begin_to_serve(self) -> None:
        """Offer the actions; from then on goals are accepted."""
        paths = PathServers(self, self._frames, lambda: self._costmap, self._plan.publish)
        self._servers = [*(self._serve(manner) for manner in MANNERS), *paths.servers]
        self.get_logger().info('Navigator ready')

    def _serve(self, manner: Manner) -> ActionServer:
        return ActionServer(
            self,
            manner.type_,
            manner.name,
            execute_callback=self._execute,
            goal_callback=partial(self._judge, manner),
            callback_group=ReentrantCallbackGroup(),  # `_judge` may wait for other callbacks
            handle_accepted_callback=partial(self._begin, manner),
            cancel_callback=self._cancel,
        )

    def destroy_node(self) -> None:
        for server in self._servers:
            server.destroy()
        self._own.destroy()
        super().destroy_node()

    def _take_map(self, grid: OccupancyGrid) -> None:
        try:
            self._costmap = Costmap(*read(grid))
        except ValueError as error:
            self.get_logger().error(f'the map is not taken: {error}')

    def _see(self, scan: LaserScan) -> None:
        pose = self._frames.robot(now(self))
        if self._costmap is None or pose is None:
            return
        laser = compose(pose, Pose2D(LASER[0], LASER[1]))
        ranges = np.asarray(scan.ranges, dtype=np.float64)
        angles = scan.angle_min + np.arange(len(ranges), dtype=np.float64) * scan.angle_increment
        self._costmap.see(laser, angles, ranges, now(self))

    def _send_goal(self, pose: PoseStamped) -> None:
        """Send a pose from the topic goal_pose to this node's action, so that user interfaces show a goal."""
        self._sent = self._own.send_goal_async(NavigateToPose.Goal(pose=pose))

    def _targets(self, manner: Manner, request: Any) -> list[Pose2D]:
        """Return the poses of a goal, on the map. Raises Refused."""
        return self._frames.all_on_map(manner.poses(request), manner.default_frame)

    async def _judge(self, manner: Manner, request: Any) -> GoalResponse:
        await self._stop.until_known()

        def check_all() -> None:
            if reason := self._stop.refusal or self._fall.refusal:
                raise Refused(reason)
            manner.time_allowed(request)
            pose = self._frames.robot(now(self))
            manner.check(request, self._costmap, pose, self._targets(manner, request))

        return judge(self, judge_by(check_all))

    def _begin(self, manner: Manner, goal_handle: ServerGoalHandle) -> None:
        """Begin a goal, and abort the running one: it is older, as goals begin in the order of acceptance."""
        self._end(Ending(End.ABORTED, 'Pre-empted by a newer goal'))
        moment, request = now(self), goal_handle.request
        poses = manner.poses(request)
        frame = (poses[-1].header.frame_id if poses else '') or manner.default_frame
        drive = Drive(
            goal_handle,
            manner,
            Errand([Pose2D()], moment),  # until its own task is made below
            frame,
            self._frames.place(frame) or Pose2D(),
            manner.time_allowed(request),
            moment,
        )
        self._drives[bytes(goal_handle.goal_id.uuid)] = self._driving = drive
        with or_abort(self, self._end):
            drive.task = manner.set_out(request, self._targets(manner, request), moment)
            self.get_logger().info(f'Goal accepted: {drive.task.aim}')
        # A stop or a fall may have happened between the goal's acceptance and its start.
        if self._stop.stopped:
            self._emergency()
        elif self._fall.fallen:
            self._fell()
        goal_handle.execute()

    def _cancel(self, _goal_handle: ServerGoalHandle) -> CancelResponse:
        self.get_logger().info('Received cancel request')
        return CancelResponse.ACCEPT

    async def _execute(self, goal_handle: ServerGoalHandle) -> Any:
        drive, ending = await carry_out(self, goal_handle, self._drives)
        progress = drive.last or self._progress(drive)
        return drive.manner.result(goal_handle.request, progress, ending, drive.task.failure)

    def _tick(self) -> None:
        if not self._servers:
            if self._is_ready:
                self._begin_to_serve()
            return
        drive = self._driving
        if drive is not None and drive.goal.is_cancel_requested:
            self._end(Ending(End.CANCELED, 'Goal canceled'))
        elif drive is not None:
            with or_abort(self, self._end):
                self._drive_on(drive)

    def _drive_on(self, drive: Drive) -> None:
        assert self._costmap is not None  # no goal is accepted without a map
        moment, task = now(self), drive.task
        velocity = task.tick(self._costmap, self._frames.robot(moment), moment)
        drive.speed = math.hypot(velocity.x, velocity.y)
        self._move(velocity)
        if task.path is not drive.shown and task.path is not None:
            drive.shown = task.path
            self._plan.publish(path_message(task.path, task.path_end, MAP, stamp(self)))
        if moment >= drive.next_feedback:
            drive.next_feedback += FEEDBACK_EVERY
            if task.is_measured:
                drive.goal.publish_feedback(drive.manner.feedback(drive.goal.request, self._progress(drive)))
        if task.ending is not None:
            self._end(task.ending)
        elif moment - task.began >= drive.allowed:
            message = f'Timed out after {drive.allowed:g} s, {task.left:.2f} m short of the target'
            self._end(Ending(End.ABORTED, message))

    def _progress(self, drive: Drive) -> Progress:
        task, pose = drive.task, self._frames.robot(now(self)) or Pose2D()
        return Progress(
            pose_message(compose(invert(drive.origin), pose), drive.frame, stamp(self)),
            now(self) - task.began,
            task.left,
            task.time_left,
            task.recoveries,
            task.poses_left,
            drive.speed,
        )

    def _move(self, velocity: Velocity2D) -> None:
        message = Twist()
        message.linear.x, message.linear.y, message.angular.z = velocity.x, velocity.y, velocity.yaw
        self._velocity.publish(message)

    def _end(self, ending: Ending) -> None:
        """If a goal is running, stop the base and decide how the goal ends."""
        drive, self._driving = self._driving, None
        if drive is not None:
            self._move(STANDING)
            drive.last = self._progress(drive)
            drive.decision.make(ending)

    def _emergency(self) -> None:
        self._end(Ending(End.ABORTED, self._stop.ended))

    def _fell(self) -> None:
        self._end(Ending(End.ABORTED, FELL))

    def _yield_to(self, command: Twist) -> None:
        """End the goal if cmd_vel asks for motion; a command of zero does not end it."""
        if command.linear.x or command.linear.y or command.angular.z:
            self._end(Ending(End.ABORTED, 'Pre-empted by cmd_vel'))

    def _hear_teleop(self, command: Twist) -> None:
        """Pass a velocity on to the goal of assisted_teleop; without such a goal it means nothing."""
        if (task := self._teleop) is not None:
            task.hear(Velocity2D(command.linear.x, command.linear.y, command.angular.z), now(self))

    def _finish_teleop(self, _message: Empty) -> None:
        if (task := self._teleop) is not None:
            task.finish()

    @property
    def _teleop(self) -> TeleopErrand | None:
        """The task that takes velocities now, if there is one."""
        task = self._driving.task if self._driving is not None else None
        return task if isinstance(task, TeleopErrand) else None

    def _show(self) -> None:
        if self._costmap is None:
            return
        pose = self._frames.robot(now(self))
        if pose is not None:
            self._local.publish(write(*self._costmap.window(pose.x, pose.y, LOCAL_HALF), MAP, stamp(self)))
        if self._shown % 4 == 0:
            geometry = self._costmap.geometry
            self._global.publish(write(geometry, self._costmap.costs(), MAP, stamp(self)))
        self._shown += 1

    def _tell_state(self, _request: GetState.Request, response: GetState.Response) -> GetState.Response:
        """Answer "active" once goals are accepted: clients of Nav2 wait for this state of bt_navigator."""
        return tell_state(response, is_active=bool(self._servers))

    def _health(self) -> Health:
        if self._stop.stopped:
            return Health(self._stop.ended.lower(), DiagnosticStatus.WARN)
        if self._fall.fallen:
            return Health(LIES, DiagnosticStatus.ERROR)
        if not self._is_ready:
            return Health('waits for the map and for where the robot is', DiagnosticStatus.WARN)
        if self._driving is None:
            return Health('waits for a goal')
        task = self._driving.task
        values = {'distance remaining': f'{task.left:.2f}', 'recoveries': task.recoveries}
        return Health(task.doing, values=values)


def main(args: Sequence[str] | None = None) -> int:
    return run(Navigator, args)


if __name__ == '__main__':
    raise SystemExit(main())
