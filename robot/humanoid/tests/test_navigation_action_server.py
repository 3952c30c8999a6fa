"""The navigation server in virtual time. Other files of this folder start it as a process."""

from __future__ import annotations

import math
import re
from collections.abc import Iterator

import pytest
from action_msgs.srv import CancelGoal
from goalwire.logging import LogRecord
from goalwire.testing import Graph, Recorder, VirtualClock
from nav_msgs.msg import Odometry

from humanoid.mission.robot import Robot
from humanoid.model import BASE
from humanoid.navigation.server import NavigationActionServer

WITHIN = 15.0


@pytest.fixture
def robot(gw_clock: VirtualClock, gw_graph: Graph) -> Iterator[Robot]:
    gw_graph.start(NavigationActionServer)
    with Robot() as client:
        yield client


@pytest.fixture
def odometry(gw_graph: Graph, robot: Robot) -> Recorder[Odometry]:
    return gw_graph.record(Odometry, 'odom')


def test_a_goal_is_driven_to_at_the_bounded_speed(gw_clock: VirtualClock, robot: Robot) -> None:
    began = gw_clock.elapsed
    with robot.drive(0.8, 0.6, allowed=10.0, timeout=WITHIN) as run:
        left = [feedback.distance_remaining for feedback in run.feedback()]
        took = gw_clock.elapsed - began
    assert (run.status, run.result.success) == ('SUCCEEDED', True)
    assert run.result.message == 'Navigation completed successfully'
    pose = run.result.final_pose
    assert (pose.header.frame_id, pose.pose.position.x, pose.pose.position.y) == ('odom', 0.8, 0.6)
    assert left == sorted(left, reverse=True)
    assert 1.0 / BASE.max_speed <= took < 1.0 / BASE.max_speed + 2.0


def test_feedback_comes_at_ten_hertz(robot: Robot) -> None:
    with robot.drive(1.2, 0.0, allowed=10.0, timeout=WITHIN) as run:
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
    robot: Robot, records: list[LogRecord], z: float, allowed: float, reason: str
) -> None:
    with robot.drive(1.0, 0.0, z, allowed=allowed, timeout=WITHIN) as run:
        assert not run.accepted
    assert any(re.search(f'Rejected: .*{reason}', record.message) for record in records)


def test_past_its_timeout_a_goal_aborts_and_says_where_it_stopped(robot: Robot) -> None:
    with robot.drive(8.0, 0.0, allowed=0.5, timeout=WITHIN) as run:
        run.finish()
    assert (run.status, run.result.success) == ('ABORTED', False)
    stopped = run.result.final_pose.pose.position.x
    assert stopped == pytest.approx(0.5 * BASE.max_speed, abs=0.1)
    assert run.result.message == f'Timed out after 0.5 s, {8.0 - stopped:.2f} m short of the target'


def test_cancel_stops_the_base_within_a_tick(
    gw_clock: VirtualClock, robot: Robot, odometry: Recorder[Odometry]
) -> None:
    with robot.drive(8.0, 0.0, allowed=20.0, timeout=WITHIN) as run:
        next(run.feedback())
        asked = gw_clock.elapsed
        run.cancel()
        run.finish()
        took = gw_clock.elapsed - asked
    assert (run.status, run.result.success) == ('CANCELED', False)
    assert took < 0.5
    still = odometry.wait_for(len(odometry.messages) + 3)[-1]
    assert (still.twist.twist.linear.x, still.twist.twist.linear.y) == (0.0, 0.0)
    stands, ended = still.pose.pose.position, run.result.final_pose.pose.position
    assert (stands.x, stands.y) == (ended.x, ended.y)


def test_odometry_shows_the_base_moving(robot: Robot, odometry: Recorder[Odometry]) -> None:
    with robot.drive(0.4, 0.0, allowed=10.0, timeout=WITHIN) as run:
        run.finish()
    speeds = [message.twist.twist.linear.x for message in odometry.messages]
    assert max(speeds) == pytest.approx(BASE.max_speed)
    assert (odometry.messages[-1].header.frame_id, odometry.messages[-1].child_frame_id) == (
        'odom',
        'base_link',
    )


def test_a_newer_goal_pre_empts_the_older_one(robot: Robot) -> None:
    with robot.drive(8.0, 0.0, allowed=20.0, timeout=WITHIN) as older:
        next(older.feedback())
        with robot.drive(0.0, 0.4, allowed=10.0, timeout=WITHIN) as newer:
            older.finish()
            newer.finish()
    assert (older.status, older.result.message) == ('ABORTED', 'Pre-empted by a newer goal')
    assert (newer.status, newer.result.message) == ('SUCCEEDED', 'Navigation completed successfully')


def test_of_ten_goals_in_a_row_only_the_last_is_driven_to_its_end(robot: Robot) -> None:
    runs = [robot.drive(5.0 + number, 0.0, allowed=20.0, timeout=WITHIN) for number in range(9)]
    runs.append(robot.drive(-0.2, 0.0, allowed=20.0, timeout=WITHIN))
    for run in runs:
        run.finish()
    assert [run.status for run in runs] == ['ABORTED'] * 9 + ['SUCCEEDED']
    assert runs[-1].result.final_pose.pose.position.x == -0.2


def test_a_goal_cut_short_by_its_client_is_cancelled(robot: Robot) -> None:
    with (
        pytest.raises(ValueError, match='enough'),
        robot.drive(8.0, 0.0, allowed=20.0, timeout=WITHIN) as run,
    ):
        raise ValueError('enough')
    assert run.status == 'CANCELED'


def test_a_cancel_after_the_end_changes_nothing(robot: Robot) -> None:
    with robot.drive(0.1, 0.0, allowed=10.0, timeout=WITHIN) as run:
        run.finish()
        reply = run.cancel()
    assert reply.return_code == CancelGoal.Response.ERROR_GOAL_TERMINATED
    assert run.status == 'SUCCEEDED'
