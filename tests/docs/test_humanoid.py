"""docs/reference/humanoid.md has the names that the robot has."""

from __future__ import annotations

import re

import pytest
from helpers.markdown import DOCS
from humanoid.arm.server import ArmActionServer
from humanoid.battery.service import BatteryService
from humanoid.description import urdf_text
from humanoid.joints.service import JointStateService
from humanoid.model import JOINTS
from humanoid.navigation.server import NavigationActionServer
from rclpy.node import Node

from goalwire.apps.programs.robot_state_publisher import RobotStatePublisher
from goalwire.testing import Graph, VirtualClock

PAGE = (DOCS / 'reference' / 'humanoid.md').read_text(encoding='utf-8')
GIVEN = {'/rosout', '/parameter_events'}


def table(heading: str) -> dict[str, list[str]]:
    """The rows of a section by the name in their first cell."""
    section = PAGE.partition(f'## {heading}\n')[2].partition('\n## ')[0]
    rows = [line.strip('| ').split(' | ') for line in section.splitlines() if line.startswith('| `')]
    return {name: row[1:] for row in rows for name in re.findall('`([^`]+)`', row[0])}


@pytest.fixture
def robot(gw_clock: VirtualClock, gw_graph: Graph) -> Node:
    arms = [
        gw_graph.start(server)
        for server in (JointStateService, NavigationActionServer, BatteryService, ArmActionServer)
    ][-1]
    gw_graph.start(lambda: RobotStatePublisher(urdf_text()))
    gw_graph.call(_trigger(), 'stand', timeout=60.0)  # its actions are there
    return arms


def _trigger() -> type:
    from std_srvs.srv import Trigger

    return Trigger


def relative(names: list[tuple[str, list[str]]]) -> dict[str, str]:
    """Without those of actions and parameters, as the page writes them."""
    absolute = {'/tf', '/tf_static', '/diagnostics'}
    return {
        name if name in absolute else name[1:]: types[0]
        for name, types in names
        if name not in GIVEN
        and '/_action/' not in name
        and not re.search('parameter|logger_level|get_type_description', name)
        and not name.startswith('/test')
    }


def test_topics_are_those_of_the_graph(robot: Node) -> None:
    documented = {name: cells[0] for name, cells in table('Topics').items()}
    assert relative(robot.get_topic_names_and_types()) == documented


def test_services_are_those_of_the_graph(robot: Node) -> None:
    documented = {name: cells[0] for name, cells in table('Services').items()}
    assert relative(robot.get_service_names_and_types()) == documented


def test_actions_are_those_of_the_graph(robot: Node) -> None:
    there = {
        name.partition('/_action/')[0][1:]: types[0].removesuffix('_SendGoal')
        for name, types in robot.get_service_names_and_types()
        if name.endswith('/_action/send_goal')
    }
    assert there == {name: cells[0] for name, cells in table('Actions').items()}


def test_joints_are_those_of_the_description() -> None:
    rows = table('Joints')
    assert list(rows) == [joint.name for joint in JOINTS]
    for joint in JOINTS:
        limits, speed, effort, home = rows[joint.name]
        assert limits == f'{joint.lower:g} to {joint.upper:g} {joint.unit}'
        assert speed == f'{joint.max_velocity:g} {joint.unit}/s'
        assert effort.split()[0] == f'{joint.max_effort:g}'
        assert home == f'{joint.home:g}'
