"""The arms' server beside that of the joints, in virtual time; once, each as a process of its own."""

from __future__ import annotations

import re
import signal
import time
from collections.abc import Iterator

import pytest
from goalwire.logging import LogRecord
from goalwire.testing import Graph, VirtualClock
from helpers.robot import humanoid, robot_client
from sensor_msgs.msg import JointState

from humanoid.arm.server import ArmActionServer
from humanoid.joints.service import JointStateService
from humanoid.mission.retry import NoAnswer
from humanoid.mission.robot import Robot

WITHIN = 15.0
SHOULDER, ELBOW = 'left_arm_shoulder', 'left_arm_elbow'


@pytest.fixture
def robot(gw_clock: VirtualClock, gw_graph: Graph) -> Iterator[Robot]:
    gw_graph.start(JointStateService)
    gw_graph.start(ArmActionServer)
    with Robot() as client:
        yield client


def test_the_joints_arrive_and_are_seen_moving(gw_graph: Graph, robot: Robot) -> None:
    seen = gw_graph.record(JointState, 'joint_states')
    seen.wait_for(1)
    with robot.reach({SHOULDER: 1.1, ELBOW: 0.4}, duration=0.8, timeout=WITHIN) as run:
        done = [feedback.fraction_done for feedback in run.feedback()]
    assert (run.status, run.result.success) == ('SUCCEEDED', True)
    assert list(run.result.final_positions) == pytest.approx([1.1, 0.4], abs=0.01)
    assert robot.joint(SHOULDER).position == pytest.approx(1.1, abs=0.01)
    assert done == sorted(done)
    assert done[0] < 0.3
    assert done[-1] > 0.9
    moving = [state for state in seen.messages if state.velocity[state.name.index(SHOULDER)] > 0.5]
    assert len(moving) > 10


def test_feedback_comes_at_twenty_hertz(robot: Robot) -> None:
    with robot.reach({SHOULDER: 1.5}, duration=1.0, timeout=WITHIN) as run:
        count = sum(1 for _ in run.feedback())
    assert count == pytest.approx(20, abs=3)


@pytest.mark.parametrize(
    ('target', 'duration', 'reason'),
    [
        ({ELBOW: 2.5}, 2.0, 'left_arm_elbow cannot go to 2.5 rad; its limits are 0.0 to 2.4 rad'),
        ({'tail': 0.0}, 2.0, "unknown joint 'tail'"),
        ({SHOULDER: 2.5}, 0.5, 'would need 4.00 rad/s'),
        ({SHOULDER: 1.0}, -1.0, 'duration -1.0 s'),
    ],
)
def test_an_impossible_goal_is_refused_and_the_reason_logged(
    robot: Robot, records: list[LogRecord], target: dict[str, float], duration: float, reason: str
) -> None:
    with robot.reach(target, duration=duration, timeout=WITHIN) as run:
        assert not run.accepted
    assert any(re.search(f'Rejected: .*{reason}', record.message) for record in records)


def test_cancel_holds_the_joints_where_they_are(robot: Robot) -> None:
    with robot.reach({SHOULDER: 2.5}, duration=5.0, timeout=WITHIN) as run:
        for feedback in run.feedback():
            if feedback.fraction_done > 0.1:
                break
        run.cancel()
        run.finish()
    assert (run.status, run.result.success) == ('CANCELED', False)
    stopped = robot.joint(SHOULDER)
    while stopped.is_moving:  # the command to hold may still be on its way
        time.sleep(0.02)  # in virtual time
        stopped = robot.joint(SHOULDER)
    assert 0.7 <= stopped.position < 1.2


def test_two_goals_on_different_joints_run_at_once_and_one_on_the_same_is_refused(
    robot: Robot, records: list[LogRecord]
) -> None:
    with (
        robot.reach({SHOULDER: 1.0}, duration=0.8, timeout=WITHIN) as left,
        robot.reach({'right_arm_shoulder': -1.0}, duration=0.8, timeout=WITHIN) as right,
        robot.reach({SHOULDER: 0.0}, duration=0.8, timeout=WITHIN) as clash,
    ):
        assert not clash.accepted
        left.finish()
        right.finish()
    assert (left.status, right.status) == ('SUCCEEDED', 'SUCCEEDED')
    assert any('Rejected: left_arm_shoulder is moving for another goal' in each.message for each in records)


@pytest.mark.slow
def test_the_action_is_offered_once_the_joints_have_been_seen_and_ends_when_they_are_lost(
    world: dict[str, str],
) -> None:
    """Each server is a process of its own."""
    with humanoid('arm_action_server', env=world) as server, robot_client() as robot:
        server.expect('waiting for joint states')
        with pytest.raises(NoAnswer, match='no action server'):
            robot.reach({SHOULDER: 1.0}, duration=1.0, timeout=0.5)
        with humanoid('joint_state_service', env=world) as joints:
            server.expect('Arm Action Server ready')
            with robot.reach({SHOULDER: 2.5}, duration=8.0, timeout=WITHIN) as run:
                assert run.accepted, server.output
                next(run.feedback())
                joints.kill()
                run.finish()
    assert run.status == 'ABORTED'
    assert 'is joint_state_service running?' in run.result.message


@pytest.mark.slow
def test_a_server_that_was_held_up_does_not_take_the_joints_for_lost(world: dict[str, str]) -> None:
    """Joint states wait for it meanwhile; it looks at them before it judges."""
    with humanoid('joint_state_service', env=world), humanoid('arm_action_server', env=world) as server:
        server.expect('Arm Action Server ready')
        with robot_client() as robot, robot.reach({SHOULDER: 1.0}, duration=1.0, timeout=WITHIN) as run:
            assert run.accepted, server.output
            next(run.feedback())
            server.send_signal(signal.SIGSTOP)
            time.sleep(1.5)  # longer than joint states may be missing
            server.send_signal(signal.SIGCONT)
            run.finish()
    assert (run.status, run.result.message) == ('SUCCEEDED', 'Arm motion completed successfully')
