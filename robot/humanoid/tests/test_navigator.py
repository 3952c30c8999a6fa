"""The navigator in virtual time, on the map of the house. The body here only moves as `cmd_vel_nav` says."""

from __future__ import annotations

import math
from collections.abc import Sequence
from itertools import pairwise
from typing import Any

import pytest
from builtin_interfaces.msg import Duration
from geometry_msgs.msg import PoseStamped, TransformStamped, Twist
from goalwire.logging import LogRecord
from goalwire.testing import Graph, VirtualClock
from nav2_msgs.action import AssistedTeleop, FollowPath, SmoothPath
from nav_msgs.msg import OccupancyGrid, Path
from rclpy.action import ActionClient
from rclpy.node import Node
from rclpy.qos import DurabilityPolicy, QoSProfile
from std_msgs.msg import Bool, Empty
from tf2_ros import StaticTransformBroadcaster, TransformBroadcaster

from humanoid.clock import stamp
from humanoid.mission.calls import GoalRun
from humanoid.navigation.base import Base, Pose2D, Velocity2D, compose
from humanoid.navigation.messages import place_frame
from humanoid.route.messages import pose_message
from humanoid.route.server import Navigator
from humanoid.world.file import load
from humanoid.world.messages import occupancy

WITHIN = 60.0
LATCHED = QoSProfile(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL)
ODOM = Pose2D(0.5, 0.2, 0.4)  # the pose of `odom` on the map
TICK = 0.05  # s
THERE = Pose2D(2.0, 0.3)


class Body(Node):
    """A map, a robot on it, and its transforms."""

    def __init__(self) -> None:
        super().__init__('body')
        self._base = Base()
        self._maps = self.create_publisher(OccupancyGrid, 'map', LATCHED)
        self._maps.publish(occupancy(load('house').solids, 0.05, stamp(self)))
        self._fixed, self._moving = StaticTransformBroadcaster(self), TransformBroadcaster(self)
        self._fixed.sendTransform(place_frame('map', ODOM, stamp(self), 'odom'))
        self.create_subscription(Twist, 'cmd_vel_nav', self._obey, 10)
        self.create_timer(TICK, self._step)

    @property
    def pose(self) -> Pose2D:
        """The robot's pose on the map."""
        return compose(ODOM, self._base.pose)

    def _obey(self, command: Twist) -> None:
        self._base.drive_at(Velocity2D(command.linear.x, command.linear.y, command.angular.z))

    def _step(self) -> None:
        self._base.step(TICK)
        moved: TransformStamped = place_frame('odom', self._base.pose, stamp(self), 'base_link')
        self._moving.sendTransform(moved)


class Client(Node):
    """Sends goals, and what else somebody says to the robot."""

    def __init__(self) -> None:
        super().__init__('client')
        self._senders: dict[Any, ActionClient[Any, Any, Any]] = {
            type_: ActionClient(self, type_, name)
            for type_, name in (
                (FollowPath, 'follow_path'),
                (SmoothPath, 'smooth_path'),
                (AssistedTeleop, 'assisted_teleop'),
            )
        }
        self.hand = self.create_publisher(Twist, 'cmd_vel', 10)
        self.teleop = self.create_publisher(Twist, 'cmd_vel_teleop', 10)
        self.done = self.create_publisher(Empty, 'preempt_teleop', 10)
        self.falls = self.create_publisher(Bool, 'fallen', LATCHED)

    def send(self, goal: Any) -> GoalRun:
        type_ = next(each for each in self._senders if isinstance(goal, each.Goal))
        return GoalRun(self._senders[type_], type_.__name__, goal, WITHIN)

    def push(self, ahead: float) -> None:
        """Publish a velocity on `cmd_vel_teleop` ten times a second, from now on."""
        command = Twist()
        command.linear.x = ahead
        self.create_timer(0.1, lambda: self.teleop.publish(command))

    def destroy_node(self) -> None:
        for client in self._senders.values():
            client.destroy()
        super().destroy_node()


@pytest.fixture
def body(gw_clock: VirtualClock, gw_graph: Graph) -> Body:
    return gw_graph.start(Body)


@pytest.fixture
def client(gw_graph: Graph, body: Body) -> Client:
    gw_graph.start(Navigator)
    return gw_graph.start(Client)


def path(*poses: Pose2D, frame: str = 'map') -> Path:
    made = Path()
    made.header.frame_id = frame
    made.poses = [pose_message(pose, '', made.header.stamp) for pose in poses]
    return made


def along(*poses: Pose2D, frame: str = 'map') -> FollowPath.Goal:
    return FollowPath.Goal(path=path(*poses, frame=frame))


def by_hand(seconds: int = 0) -> AssistedTeleop.Goal:
    return AssistedTeleop.Goal(time_allowance=Duration(sec=seconds))


def smooth(given: Path, **fields: Any) -> SmoothPath.Goal:
    return SmoothPath.Goal(path=given, max_smoothing_duration=Duration(sec=20), **fields)


def apart(pose: Pose2D, other: Pose2D) -> float:
    return math.hypot(other.x - pose.x, other.y - pose.y)


def test_a_path_is_followed_in_whatever_frame_it_is(client: Client, body: Body) -> None:
    """The robot begins where `odom` lies, so both paths lead to the same place."""
    end = compose(ODOM, Pose2D(1.5, 0.0, 1.0))
    with client.send(along(Pose2D(), Pose2D(1.5, 0.0, 1.0), frame='base_link')) as run:
        told = list(run.feedback())
    assert (run.status, run.result.error_code, run.result.error_msg) == ('SUCCEEDED', 0, '')
    assert apart(body.pose, end) < 0.06
    assert body.pose.yaw == pytest.approx(end.yaw, abs=0.06)
    assert told[0].distance_to_goal == pytest.approx(1.5, abs=0.1)
    assert told[-1].distance_to_goal < 0.2
    assert max(feedback.speed for feedback in told) == pytest.approx(0.6)
    with client.send(along(Pose2D(1.5, 0.0), Pose2D(0.2, 0.0), frame='odom')) as back:
        back.finish()
    assert back.status == 'SUCCEEDED'
    assert apart(body.pose, compose(ODOM, Pose2D(0.2, 0.0))) < 0.06


@pytest.mark.parametrize(
    ('goal', 'reason'),
    [
        (FollowPath.Goal(), 'the path is empty'),
        (along(Pose2D(), THERE, frame='moon'), "frame_id 'moon' is unknown to TF"),
        (along(Pose2D(), Pose2D(math.nan, 0.0)), 'is not within 1000 m'),
        (FollowPath.Goal(path=path(THERE), controller_id='mine'), "controller_id 'mine' is not there"),
    ],
    ids=['empty', 'in an unknown frame', 'not a number', 'by an unknown controller'],
)
def test_a_path_that_cannot_be_followed_is_refused_and_the_reason_logged(
    client: Client, records: list[LogRecord], goal: FollowPath.Goal, reason: str
) -> None:
    with client.send(goal) as run:
        assert not run.accepted
    assert any(record.message.startswith('Rejected: ') and reason in record.message for record in records)


def test_a_smooth_path_has_the_frame_and_the_ends_of_the_given_one(client: Client, gw_graph: Graph) -> None:
    shown = gw_graph.record(Path, 'plan_smoothed')
    given = path(Pose2D(0.0, 0.0, 2.0), Pose2D(2.0, 0.0), Pose2D(2.0, -1.2, -1.0), frame='odom')
    with client.send(smooth(given, check_for_collisions=True)) as run:
        run.finish()
    result = run.result
    assert (run.status, result.error_code, result.was_completed) == ('SUCCEEDED', 0, True)
    assert result.path.header.frame_id == result.path.poses[1].header.frame_id == 'odom'
    assert result.path.poses[0].pose == given.poses[0].pose
    assert result.path.poses[-1].pose == given.poses[-1].pose
    assert sharpest_turn(result.path.poses[1:-1]) < 0.3
    assert result.smoothing_duration.sec < 20
    assert shown.wait_for(1)[0] == result.path


def sharpest_turn(poses: Sequence[PoseStamped]) -> float:
    """The largest turn between a pose and the next, in rad."""
    yaws = [2.0 * math.atan2(each.pose.orientation.z, each.pose.orientation.w) for each in poses]
    return max(abs(math.remainder(after - before, math.tau)) for before, after in pairwise(yaws))


@pytest.mark.parametrize(
    ('goal', 'code', 'message'),
    [
        (smooth(path(THERE), smoother_id='mine'), 501, "smoother_id 'mine' is not there"),
        (smooth(Path()), 505, 'the path is empty'),
        (smooth(path(Pose2D(), THERE, frame='moon')), 505, "frame_id 'moon' is unknown to TF"),
        (
            smooth(path(Pose2D(4.0, 2.5), Pose2D(7.0, 2.5)), check_for_collisions=True),
            503,
            'the path comes nearer than 0.4 m to something, near (5.1, 2.5) m on the map',
        ),
    ],
    ids=['by an unknown smoother', 'empty', 'in an unknown frame', 'through a wall'],
)
def test_a_path_that_cannot_be_made_smooth_ends_with_the_code_of_nav2(
    client: Client, goal: SmoothPath.Goal, code: int, message: str
) -> None:
    with client.send(goal) as run:
        run.finish()
    assert (run.status, run.result.error_code) == ('ABORTED', code)
    assert message in run.result.error_msg


def test_a_path_comes_back_as_it_was_if_there_is_no_time_or_collisions_are_not_asked_for(
    client: Client,
) -> None:
    through_a_wall = path(Pose2D(4.0, 2.5), Pose2D(7.0, 2.5))
    with client.send(smooth(through_a_wall)) as run:
        run.finish()
    assert (run.status, run.result.was_completed) == ('SUCCEEDED', True)
    with client.send(SmoothPath.Goal(path=path(Pose2D(), Pose2D(2.0, 0.0), Pose2D(2.0, 1.5)))) as hasty:
        hasty.finish()
    assert (hasty.status, hasty.result.was_completed) == ('SUCCEEDED', False)
    corner = hasty.result.path.poses[20].pose.position
    assert (corner.x, corner.y) == pytest.approx((2.0, 0.0))


def test_somebody_drives_the_robot_until_the_time_is_over(client: Client, body: Body) -> None:
    client.push(0.5)
    began = body.pose
    with client.send(by_hand(2)) as run:
        told = [feedback.current_teleop_duration for feedback in run.feedback()]
    assert (run.status, run.result.error_code) == ('ABORTED', AssistedTeleop.Result.TIMEOUT)
    assert run.result.error_msg == 'Assisted teleop is over: it was allowed for 2 s'
    assert run.result.total_elapsed_time.sec == 2
    assert 0.7 < apart(began, body.pose) < 1.1
    passed = [each.sec + each.nanosec / 1e9 for each in told]
    assert passed == sorted(passed)
    assert len(passed) == pytest.approx(20, abs=3)


def test_somebody_says_that_the_robot_is_where_it_should_be(client: Client) -> None:
    with client.send(by_hand()) as run:
        next(run.feedback())
        client.done.publish(Empty())
        run.finish()
    assert (run.status, run.result.error_code, run.result.error_msg) == ('SUCCEEDED', 0, '')


GOALS = pytest.mark.parametrize('goal', [along(Pose2D(), THERE), by_hand()], ids=['path', 'teleop'])


@GOALS
def test_a_newer_goal_and_a_hand_on_cmd_vel_take_over(client: Client, goal: Any) -> None:
    with client.send(goal) as older:
        next(older.feedback())
        with client.send(by_hand()) as newer:
            older.finish()
            push = Twist()
            push.angular.z = 0.3
            client.hand.publish(push)
            newer.finish()
    assert (older.status, older.result.error_msg) == ('ABORTED', 'Pre-empted by a newer goal')
    assert (newer.status, newer.result.error_msg) == ('ABORTED', 'Pre-empted by cmd_vel')


@GOALS
def test_the_emergency_stop_ends_it_and_refuses_the_next(client: Client, goal: Any) -> None:
    with client.send(goal) as run:
        next(run.feedback())
        stops = client.create_publisher(Bool, 'emergency_stopped', 10)
        client.create_timer(0.1, lambda: stops.publish(Bool(data=True)))
        run.finish()
    assert run.status == 'ABORTED'
    assert run.result.error_msg.startswith('Emergency stop')
    with client.send(goal) as refused:
        assert not refused.accepted


@GOALS
def test_a_fall_ends_it_and_refuses_the_next(client: Client, goal: Any) -> None:
    with client.send(goal) as run:
        next(run.feedback())
        client.falls.publish(Bool(data=True))
        run.finish()
    assert (run.status, run.result.error_msg) == ('ABORTED', 'The robot has fallen')
    with client.send(goal) as refused:
        assert not refused.accepted


@GOALS
def test_a_cancelled_goal_ends_so(client: Client, goal: Any) -> None:
    with client.send(goal) as run:
        next(run.feedback())
        run.cancel()
        run.finish()
    assert (run.status, run.result.error_code) == ('CANCELED', 0)
