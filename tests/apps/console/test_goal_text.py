"""Lanes say of a goal what it asks for."""

from __future__ import annotations

import math
from typing import Any

import pytest
from control_msgs.action import FollowJointTrajectory
from example_interfaces.action import Fibonacci
from geometry_msgs.msg import PoseStamped
from nav2_msgs.action import NavigateThroughPoses, NavigateToPose
from trajectory_msgs.msg import JointTrajectoryPoint

from goalwire.apps.console.state.goal_text import describe_goal
from goalwire.observe.messages import as_data


def at(x: float, y: float, degrees: float | None = None) -> PoseStamped:
    pose = PoseStamped()
    pose.pose.position.x, pose.pose.position.y = x, y
    pose.pose.orientation.w = 0.0
    if degrees is not None:
        half = math.radians(degrees) / 2.0
        pose.pose.orientation.z, pose.pose.orientation.w = math.sin(half), math.cos(half)
    return pose


def trajectory(*positions: float) -> FollowJointTrajectory.Goal:
    goal = FollowJointTrajectory.Goal()
    goal.trajectory.joint_names = [f'joint_{number}' for number in range(len(positions))]
    goal.trajectory.points = [JointTrajectoryPoint(positions=list(positions))]
    return goal


@pytest.mark.parametrize(
    ('goal', 'text'),
    [
        (NavigateToPose.Goal(pose=at(2.0, 0.0, 90.0)), 'to 2.0, 0.0 facing 90°'),
        (NavigateToPose.Goal(pose=at(2.0, -1.25)), 'to 2.0, -1.2'),
        (NavigateToPose.Goal(pose=at(math.nan, 0.0, math.nan)), 'to nan, 0.0'),
        (
            NavigateThroughPoses.Goal(poses=[at(1.0, 1.0), at(4.0, 2.0, -45.0)]),
            'through 1 to 4.0, 2.0 facing -45°',
        ),
        (trajectory(0.5), 'joint_0 0.50'),
        (trajectory(0.5, 1.0, 1.5, 2.0), 'joint_0 0.50, joint_1 1.00, 2 more'),
        (Fibonacci.Goal(order=5), 'order 5'),
    ],
    ids=lambda value: value if isinstance(value, str) else '',
)
def test_a_goal_says_what_it_asks_for(goal: Any, text: str) -> None:
    assert describe_goal(as_data(goal)) == text


@pytest.mark.parametrize(
    ('request_', 'text'),
    [
        ({}, ''),
        ({'x': 1.0, 'y': 2.5, 'speed': 0.5}, 'to 1.0, 2.5'),
        ({'goal': {'header': {}, 'pose': {'position': [1.0], 'orientation': {'roll': 1.0}}}}, ''),
        ({'poses': [as_data(at(1.0, 1.0)), '… 300 items']}, 'through more than 1'),
        ({'pose': 3, 'header': 4}, 'pose 3, header 4'),
        ({'points': 'none', 'joint_names': 7}, 'points none, joint_names 7'),
        ({'text': 'a' * 100}, f'text {"a" * 54}…'),
    ],
)
def test_goals_of_any_shape_have_a_text(request_: dict[str, Any], text: str) -> None:
    assert describe_goal(request_) == text
