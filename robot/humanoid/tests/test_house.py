"""`humanoid up --world house`: the robot finds its way among walls, doors and people."""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Iterator
from typing import Any

import pytest
from geometry_msgs.msg import PoseStamped, PoseWithCovarianceStamped, Twist
from helpers.collector import Collector
from helpers.markdown import DOCS
from helpers.processes import Program
from helpers.robot import humanoid, on_both_wires, robot_client
from lifecycle_msgs.srv import GetState
from nav2_msgs.action import ComputePathToPose, NavigateThroughPoses, NavigateToPose
from nav_msgs.msg import OccupancyGrid, Odometry, Path
from rclpy.action import ActionClient
from rclpy.qos import DurabilityPolicy, QoSProfile, qos_profile_sensor_data
from sensor_msgs.msg import LaserScan
from std_msgs.msg import Bool, Float64
from visualization_msgs.msg import MarkerArray

from humanoid.mission.calls import GoalRun
from humanoid.mission.robot import Robot
from humanoid.navigation.base import Pose2D, turn_between
from humanoid.navigation.messages import target_of

pytestmark = [pytest.mark.slow, pytest.mark.timeout(400)]

WITHIN = 90.0
LATCHED = QoSProfile(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL)


@pytest.fixture(scope='module')
def up(shared_world: dict[str, str]) -> Iterator[Program]:
    with humanoid('up', '--world', 'house', env=shared_world) as program:
        program.expect(r'\[navigator\] .*Navigator ready', timeout=60.0)
        yield program


@pytest.fixture
def robot(up: Program) -> Iterator[Robot]:
    """A client; the robot stands at home, with all doors open."""
    with robot_client() as client:
        for door in client.doors():
            client.move_door(door, is_open=True)
        with client.drive(0.0, 0.0, allowed=80.0, timeout=WITHIN) as run:
            run.finish()
        assert run.status == 'SUCCEEDED', run.result.message
        yield client


def listen(robot: Robot, type_: Any, topic: str, qos: Any = 10) -> Collector[Any]:
    seen: Collector[Any] = Collector()
    robot.node.create_subscription(type_, topic, seen, qos)
    return seen


def pose(x: float, y: float, frame: str = 'map', yaw: float = 0.0) -> PoseStamped:
    message = PoseStamped()
    message.header.frame_id = frame
    message.pose.position.x, message.pose.position.y = x, y
    message.pose.orientation.z, message.pose.orientation.w = math.sin(yaw / 2.0), math.cos(yaw / 2.0)
    return message


class Senders:
    """Clients of Nav2's actions, each made when it is needed."""

    def __init__(self, robot: Robot) -> None:
        self._robot = robot
        self.clients: dict[str, ActionClient[Any, Any, Any]] = {}

    def send(self, type_: Any, name: str, goal: Any) -> GoalRun:
        if name not in self.clients:
            self.clients[name] = ActionClient(self._robot.node, type_, name)
        return GoalRun(self.clients[name], name, goal, WITHIN)

    def to(self, x: float, y: float, yaw: float = 0.0, frame: str = 'map') -> GoalRun:
        """NavigateToPose."""
        return self.send(NavigateToPose, 'navigate_to_pose', NavigateToPose.Goal(pose=pose(x, y, frame, yaw)))

    def through(self, *poses: PoseStamped) -> GoalRun:
        goal = NavigateThroughPoses.Goal(poses=list(poses))
        return self.send(NavigateThroughPoses, 'navigate_through_poses', goal)


@pytest.fixture
def nav2(robot: Robot) -> Iterator[Senders]:
    senders = Senders(robot)
    yield senders
    for client in senders.clients.values():
        client.destroy()


def test_it_goes_to_another_room_knows_where_it_is_and_touches_nothing(robot: Robot, nav2: Senders) -> None:
    truths = listen(robot, Odometry, 'ground_truth', 500)
    beliefs = listen(robot, PoseWithCovarianceStamped, 'amcl_pose')
    clearances, plans = listen(robot, Float64, 'clearance', 500), listen(robot, Path, 'plan')
    with nav2.to(7.0, 3.0, yaw=1.5) as run:
        told = list(run.feedback())
    assert (run.status, run.result.error_code) == ('SUCCEEDED', 0)
    assert told[0].distance_remaining > 7.0
    assert told[-1].distance_remaining < 0.3
    assert told[0].estimated_time_remaining.sec > 8
    truth = target_of(truths.items[-1].pose.pose)
    assert math.hypot(truth.x - 7.0, truth.y - 3.0) < 0.15
    assert abs(turn_between(truth.yaw, 1.5)) < 0.15
    assert max(errors(truths.items, beliefs.items)) < 0.1
    assert min(each.data for each in clearances.items) > 0.0
    assert plans.items[0].header.frame_id == 'map'
    assert len(plans.items[0].poses) > 70


def errors(truths: list[Odometry], beliefs: list[PoseWithCovarianceStamped]) -> list[float]:
    """How far the localiser was off, at each scan of which the truth is known: m."""
    known = {(each.header.stamp.sec, each.header.stamp.nanosec): target_of(each.pose.pose) for each in truths}
    off = []
    for belief in beliefs:
        true = known.get((belief.header.stamp.sec, belief.header.stamp.nanosec))
        if true is not None:
            found: Pose2D = target_of(belief.pose.pose)
            off.append(math.hypot(found.x - true.x, found.y - true.y))
    assert len(off) > 20
    return off


@pytest.mark.long
def test_a_door_that_closes_on_the_way_makes_it_plan_anew(robot: Robot, nav2: Senders) -> None:
    clearances, plans = listen(robot, Float64, 'clearance', 500), listen(robot, Path, 'plan')
    with nav2.to(7.0, 3.0) as run:
        for feedback in run.feedback():
            if feedback.current_pose.pose.position.x > 2.5:
                break
        assert robot.move_door('kitchen', is_open=False).success
        run.finish()
    assert run.status == 'SUCCEEDED'
    assert max(each.pose.position.y for each in plans.items[0].poses) < 4.0, 'through the kitchen door'
    assert any(max(each.pose.position.y for each in plan.poses) > 4.0 for plan in plans.items), (
        'round by the corridor'
    )
    assert min(each.data for each in clearances.items) > 0.0


def test_what_cannot_be_reached_is_refused_with_the_reason(up: Program, robot: Robot, nav2: Senders) -> None:
    for x, frame, reason in (
        (5.5, 'map', r'the goal \(5.50, -1.00\) m is 0.00 m from a thing of the map'),
        (50.0, 'map', 'is off the map'),
        (1.0, 'moon', "frame_id 'moon' is unknown to TF"),
        (math.nan, 'map', 'is not within 1000 m'),
    ):
        with nav2.to(x, -1.0, frame=frame) as run:
            assert not run.accepted
        up.expect(f'Rejected: .*{reason}')


@pytest.mark.long
def test_what_can_no_longer_be_reached_is_aborted_with_the_reason(robot: Robot, nav2: Senders) -> None:
    for door in ('living_room', 'kitchen'):
        assert robot.move_door(door, is_open=False).success
    with nav2.to(7.0, 3.0) as run:
        run.finish()
    assert (run.status, run.result.error_code) == ('ABORTED', ComputePathToPose.Result.NO_VALID_PATH)
    assert 'No way: the map shows one, and something stands on it near (5.' in run.result.error_msg


def test_the_emergency_stop_ends_each_action_and_refuses_the_next(robot: Robot, nav2: Senders) -> None:
    truths = listen(robot, Odometry, 'ground_truth')
    sends: tuple[Callable[[], GoalRun], ...] = (
        lambda: nav2.to(4.5, 2.5),
        lambda: nav2.through(pose(1.5, 1.0), pose(3.0, 1.0)),
    )
    for send in sends:
        with send() as run:
            next(run.feedback())
            assert robot.emergency_stop(stopped=True).success
            run.finish()
        assert (run.status, run.result.error_msg) == ('ABORTED', 'Emergency stop')
        still = truths.expect(len(truths.items) + 30)[-20:]
        assert {(each.twist.twist.linear.x, each.twist.twist.angular.z) for each in still} == {(0.0, 0.0)}
        with send() as refused:
            assert not refused.accepted
        assert robot.emergency_stop(stopped=False).success
        accepted = False
        while not accepted:  # it hears of the release a moment later; bounded by the test's time limit
            with send() as run:
                accepted = run.accepted


def test_a_fall_ends_each_action_and_refuses_the_next_until_it_stands(
    up: Program, robot: Robot, nav2: Senders
) -> None:
    falls = robot.node.create_publisher(Bool, 'fallen', LATCHED)
    sends: tuple[Callable[[], GoalRun], ...] = (
        lambda: nav2.to(4.5, 2.5),
        lambda: nav2.through(pose(1.5, 1.0), pose(3.0, 1.0)),
    )
    for send in sends:
        with send() as run:
            next(run.feedback())
            falls.publish(Bool(data=True))
            run.finish()
        assert (run.status, run.result.error_msg) == ('ABORTED', 'The robot has fallen')
        with send() as refused:
            assert not refused.accepted
        up.expect('Rejected: the robot has fallen; humanoid get_up puts it back on its feet')
        falls.publish(Bool(data=False))
        accepted = False
        while not accepted:  # it hears of it a moment later; bounded by the test's time limit
            with send() as run:
                accepted = run.accepted


def test_cancel_newer_goals_and_a_hand_on_cmd_vel_end_a_drive(robot: Robot, nav2: Senders) -> None:
    with nav2.to(4.5, 2.5) as run:
        next(run.feedback())
        run.cancel()
        run.finish()
    assert run.status == 'CANCELED'
    with nav2.to(4.5, 2.5) as older:
        next(older.feedback())
        with robot.drive(1.0, 1.0, allowed=30.0, timeout=WITHIN) as newer:
            older.finish()
            newer.finish()
    assert (older.status, older.result.error_msg) == ('ABORTED', 'Pre-empted by a newer goal')
    assert newer.status == 'SUCCEEDED'
    hand = robot.node.create_publisher(Twist, 'cmd_vel', 10)
    with nav2.to(4.5, 2.5) as taken:
        next(taken.feedback())
        push = Twist()
        push.angular.z = 0.3
        hand.publish(push)
        taken.finish()
    assert (taken.status, taken.result.error_msg) == ('ABORTED', 'Pre-empted by cmd_vel')


@pytest.mark.long
def test_walls_stop_a_hand_on_cmd_vel(up: Program, robot: Robot) -> None:
    """South of the robot is a wall, 1.95 m away."""
    clearances = listen(robot, Float64, 'clearance')
    hand = robot.node.create_publisher(Twist, 'cmd_vel', 10)
    push = Twist()
    push.linear.y = -0.5
    timer = robot.node.create_timer(0.1, lambda: hand.publish(push))
    up.expect('cmd_vel is slowed down or stopped', timeout=30.0)
    seen = clearances.expect(len(clearances.items) + 20)
    robot.node.destroy_timer(timer)
    assert 0.0 < seen[-1].data < 0.25
    assert min(each.data for each in seen) > 0.0


def test_programs_for_nav2_find_what_they_wait_for(robot: Robot, nav2: Senders) -> None:
    for name in ('amcl', 'bt_navigator'):
        client = robot.node.create_client(GetState, f'{name}/get_state')
        assert client.wait_for_service(timeout_sec=10.0)
        answer = client.call(GetState.Request(), timeout_sec=10.0)
        assert answer is not None
        assert answer.current_state.label == 'active'
    # In the room of the robot: a person who stands in a doorway closes the ways to others.
    planned = ComputePathToPose.Goal(goal=pose(4.0, 2.0), start=pose(0.0, 0.0), use_start=True)
    with nav2.send(ComputePathToPose, 'compute_path_to_pose', planned) as run:
        run.finish()
    assert run.status == 'SUCCEEDED'
    assert run.result.path.poses[-1].pose.position.x == 4.0


def test_initialpose_moves_the_robot_on_its_map_and_the_scan_corrects_it(robot: Robot) -> None:
    beliefs = listen(robot, PoseWithCovarianceStamped, 'amcl_pose')
    tell = robot.node.create_publisher(PoseWithCovarianceStamped, 'initialpose', 1)
    guess = PoseWithCovarianceStamped()
    guess.header.frame_id = 'map'
    guess.pose.pose = pose(0.4, -0.3, yaw=0.3).pose
    tell.publish(guess)
    found = target_of(beliefs.expect(len(beliefs.items) + 15)[-1].pose.pose)
    assert math.hypot(found.x, found.y) < 0.1
    assert abs(found.yaw) < 0.09


def test_goals_may_be_in_any_frame_and_come_by_goal_pose(up: Program, robot: Robot) -> None:
    sender = robot.node.create_publisher(PoseStamped, 'goal_pose', 1)
    up_to = listen(robot, Path, 'plan')
    while not sender.get_subscription_count():
        robot.next_message(Odometry, 'odom')
    sender.publish(pose(1.0, 0.0, 'base_link'))
    end = up_to.expect(1, timeout=30.0)[0].poses[-1].pose.position
    assert math.hypot(end.x - 1.0, end.y) < 0.1
    up.expect('Navigation completed successfully', timeout=30.0)


def test_screens_get_the_world_the_map_the_scan_and_costmaps(up: Program, robot: Robot) -> None:
    [markers] = listen(robot, MarkerArray, 'world_markers', LATCHED).expect(1)[:1]
    assert {'wall', 'furniture', 'person'} <= {marker.ns for marker in markers.markers}
    for topic in ('map', 'global_costmap/costmap', 'local_costmap/costmap'):
        [grid] = listen(robot, OccupancyGrid, topic, LATCHED).expect(1)[:1]
        assert grid.header.frame_id == 'map'
        assert max(grid.data) == 100
    [scan] = listen(robot, LaserScan, 'scan', qos_profile_sensor_data).expect(1)[:1]
    assert scan.header.frame_id == 'laser'
    assert len(scan.ranges) == 360


def test_the_page_of_names_has_the_topics_of_a_world(robot: Robot) -> None:
    page = (DOCS / 'reference' / 'humanoid.md').read_text(encoding='utf-8')
    section = page.partition('## Topics of a world\n')[2].partition('\n## ')[0]
    documented = dict(re.findall(r'^\| `([^`]+)` \| (\S+) \|', section, re.MULTILINE))
    there = {name[1:]: types[0] for name, types in robot.node.get_topic_names_and_types()}
    assert documented.items() <= there.items()
    extra = {
        name
        for name in there
        if re.search('map|scan|pose|plan|world|nav|truth|clearance|camera|teleop', name)
    }
    assert {name for name in extra if '_action' not in name} == set(documented)


def test_doors_are_moved_from_the_command_line(up: Program, shared_world: dict[str, str]) -> None:
    with humanoid('door', 'kitchen', 'close', env=shared_world) as closed:
        assert closed.succeed().strip() == 'the door kitchen is closed'
    with humanoid('door', 'attic', 'open', env=shared_world) as missing:
        assert missing.wait() == 1
    assert "there is no door 'attic'; there are bedroom, kitchen, living_room" in missing.output


@pytest.mark.long
@on_both_wires
def test_the_mission_is_carried_out_in_the_house(world: dict[str, str]) -> None:
    with humanoid('demo', '--world', 'house', env=world | {'COLUMNS': '160'}) as demo:
        output = demo.succeed(timeout=250.0)
    assert '12 of 12 steps ended as they should' in output
    assert re.search(r'closed with \d\.\d m to go; 1\d\.\d m by the other way; SUCCEEDED', output)


@pytest.mark.parametrize(
    ('arguments', 'problem'),
    [
        (['up', '--world', 'castle'], "there is no world 'castle'; use flat, house"),
        (['demo', '--world', './none.yaml'], 'none.yaml: it cannot be read'),
        (['up', '--world', 'house', '--name', 'a', '--name', 'b'], 'a world has room for one robot'),
    ],
)
def test_a_world_that_cannot_be_is_told_in_a_line(
    world: dict[str, str], arguments: list[str], problem: str
) -> None:
    with humanoid(*arguments, env=world) as program:
        assert program.wait() == 1
    assert problem in program.output
    assert 'Traceback' not in program.output
