"""Tests the programs of the chapter "ROS 2 Services and Actions" as they are, without a robot."""

import joint_state_client
import navigation_action_server
import pytest
from humanoid_interfaces.action import MoveToPosition
from humanoid_interfaces.srv import GetJointState

from goalwire import DeadlineError, GoalRefused


def goal(x, timeout, z=0.0):
    made = MoveToPosition.Goal(timeout=timeout)
    made.target_pose.pose.position.x = x
    made.target_pose.pose.position.z = z
    return made


def test_the_client_asks_for_three_joints_and_waits_for_its_server_as_long_as_that_takes(gw_clock, gw_graph):
    program = gw_graph.run(joint_state_client.main, node='joint_state_client')
    with pytest.raises(AssertionError, match='did not end within 3600 s'):
        program.wait(timeout=3600.0)
    service = gw_graph.service(GetJointState, 'get_joint_state', GetJointState.Response(position=0.5))
    program.wait()
    assert [request.joint_name for request in service.requests] == [
        'left_arm_shoulder',
        'right_knee',
        'left_knee',
    ]


def test_the_drive_takes_the_time_that_it_is_given(gw_clock, gw_graph):
    gw_graph.run(navigation_action_server.main, node='navigation_action_server')
    outcome = gw_graph.send_goal(MoveToPosition, 'move_to_position', goal(x=3.0, timeout=30.0))
    assert outcome.result.message == 'Navigation completed successfully'
    assert len(outcome.feedback) == 301
    assert gw_clock.elapsed == 30.0


def test_below_the_floor_it_does_not_drive(gw_clock, gw_graph):
    gw_graph.run(navigation_action_server.main, node='navigation_action_server')
    with pytest.raises(GoalRefused):
        gw_graph.send_goal(MoveToPosition, 'move_to_position', goal(x=3.0, timeout=30.0, z=-1.0))


def test_a_drive_is_cancelled_within_a_tenth_of_a_second(gw_clock, gw_graph):
    gw_graph.run(navigation_action_server.main, node='navigation_action_server')
    with pytest.raises(DeadlineError):
        gw_graph.send_goal(MoveToPosition, 'move_to_position', goal(x=3.0, timeout=30.0), timeout=5.05)
    assert gw_clock.elapsed == pytest.approx(5.1)
