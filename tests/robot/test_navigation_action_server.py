"""navigation_action_server as its own process, given goals from this one."""

from __future__ import annotations

import math
import time
from collections.abc import Iterator

import pytest
from action_msgs.srv import CancelGoal
from helpers.collector import Collector
from helpers.processes import Program
from helpers.robot import humanoid, robot_client
from humanoid.mission.robot import Robot
from humanoid.model import BASE
from humanoid.navigation.server import NavigationActionServer
from nav_msgs.msg import Odometry

from goalwire.testing import Graph, VirtualClock

pytestmark = pytest.mark.slow

WITHIN = 15.0


@pytest.fixture
def server(world: dict[str, str]) -> Iterator[Program]:
    with humanoid('navigation_action_server', env=world) as program:
        program.expect('Navigation Action Server ready')
        yield program


@pytest.fixture
def odometry(robot: Robot) -> Collector[Odometry]:
    seen: Collector[Odometry] = Collector()
    robot.node.create_subscription(Odometry, 'odom', seen, 100)
    return seen


def test_a_goal_is_driven_to_at_the_bounded_speed(server: Program, robot: Robot) -> None:
    began = time.monotonic()
    with robot.drive(0.8, 0.6, allowed=10.0, timeout=WITHIN) as run:
        left = [feedback.distance_remaining for feedback in run.feedback()]
        took = time.monotonic() - began
    assert (run.status, run.result.success) == ('SUCCEEDED', True)
    assert run.result.message == 'Navigation completed successfully'
    pose = run.result.final_pose
    assert (pose.header.frame_id, pose.pose.position.x, pose.pose.position.y) == ('odom', 0.8, 0.6)
    assert left == sorted(left, reverse=True)
    assert 1.0 / BASE.max_speed <= took < 1.0 / BASE.max_speed + 2.0


def test_feedback_comes_at_ten_hertz(gw_clock: VirtualClock, gw_graph: Graph) -> None:
    gw_graph.start(NavigationActionServer)
    with robot_client() as robot, robot.drive(1.2, 0.0, allowed=10.0, timeout=WITHIN) as run:
        elapsed = [feedback.elapsed_time for feedback in run.feedback()]
    assert len(elapsed) == pytest.approx(1.2 / BASE.max_speed * 10, abs=2)
    assert (elapsed[-1] - elapsed[0]) / (len(elapsed) - 1) == pytest.approx(0.1, abs=0.02)


@pytest.mark.parametrize(
    ('z', 'allowed', 'reason'),
    [
        (-0.1, 10.0, 'below the floor'),
        (math.nan, 10.0, 'not within 1000 m'),
        (0.0, 0.0, 'timeout 0.0 s'),
        (0.0, -1.0, 'timeout -1.0 s'),
        (0.0, math.nan, 'timeout nan s'),
        (0.0, math.inf, 'timeout inf s'),
    ],
)
def test_an_impossible_goal_is_refused_and_the_reason_logged(
    server: Program, robot: Robot, z: float, allowed: float, reason: str
) -> None:
    with robot.drive(1.0, 0.0, z, allowed=allowed, timeout=WITHIN) as run:
        assert not run.accepted
    server.expect(f'Rejected: .*{reason}')


def test_past_its_timeout_a_goal_aborts_and_says_where_it_stopped(server: Program, robot: Robot) -> None:
    with robot.drive(8.0, 0.0, allowed=0.5, timeout=WITHIN) as run:
        run.finish()
    assert (run.status, run.result.success) == ('ABORTED', False)
    stopped = run.result.final_pose.pose.position.x
    assert stopped == pytest.approx(0.5 * BASE.max_speed, abs=0.1)
    assert run.result.message == f'Timed out after 0.5 s, {8.0 - stopped:.2f} m short of the target'


def test_cancel_stops_the_base_within_a_tick(
    server: Program, robot: Robot, odometry: Collector[Odometry]
) -> None:
    with robot.drive(8.0, 0.0, allowed=20.0, timeout=WITHIN) as run:
        next(run.feedback())
        asked = time.monotonic()
        run.cancel()
        run.finish()
        took = time.monotonic() - asked
    assert (run.status, run.result.success) == ('CANCELED', False)
    assert took < 0.5
    still = odometry.expect(len(odometry.items) + 3)[-1]
    assert (still.twist.twist.linear.x, still.twist.twist.linear.y) == (0.0, 0.0)
    stands, ended = still.pose.pose.position, run.result.final_pose.pose.position
    assert (stands.x, stands.y) == (ended.x, ended.y)


def test_odometry_shows_the_base_moving(server: Program, robot: Robot, odometry: Collector[Odometry]) -> None:
    with robot.drive(0.4, 0.0, allowed=10.0, timeout=WITHIN) as run:
        run.finish()
    speeds = [message.twist.twist.linear.x for message in odometry.items]
    assert max(speeds) == pytest.approx(BASE.max_speed)
    assert (odometry.items[-1].header.frame_id, odometry.items[-1].child_frame_id) == ('odom', 'base_link')


def test_a_newer_goal_pre_empts_the_older_one(server: Program, robot: Robot) -> None:
    with robot.drive(8.0, 0.0, allowed=20.0, timeout=WITHIN) as older:
        next(older.feedback())
        with robot.drive(0.0, 0.4, allowed=10.0, timeout=WITHIN) as newer:
            older.finish()
            newer.finish()
    assert (older.status, older.result.message) == ('ABORTED', 'Pre-empted by a newer goal')
    assert (newer.status, newer.result.message) == ('SUCCEEDED', 'Navigation completed successfully')


def test_of_ten_goals_in_a_row_only_the_last_is_driven_to_its_end(server: Program, robot: Robot) -> None:
    runs = [robot.drive(5.0 + number, 0.0, allowed=20.0, timeout=WITHIN) for number in range(9)]
    runs.append(robot.drive(-0.2, 0.0, allowed=20.0, timeout=WITHIN))
    for run in runs:
        run.finish()
    assert [run.status for run in runs] == ['ABORTED'] * 9 + ['SUCCEEDED']
    assert runs[-1].result.final_pose.pose.position.x == -0.2


def test_a_goal_cut_short_by_its_client_is_cancelled(server: Program, robot: Robot) -> None:
    with (
        pytest.raises(ValueError, match='enough'),
        robot.drive(8.0, 0.0, allowed=20.0, timeout=WITHIN) as run,
    ):
        raise ValueError('enough')
    assert run.status == 'CANCELED'


def test_a_cancel_after_the_end_changes_nothing(server: Program, robot: Robot) -> None:
    with robot.drive(0.1, 0.0, allowed=10.0, timeout=WITHIN) as run:
        run.finish()
        reply = run.cancel()
    assert reply.return_code == CancelGoal.Response.ERROR_GOAL_TERMINATED
    assert run.status == 'SUCCEEDED'
