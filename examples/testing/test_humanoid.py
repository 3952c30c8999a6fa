"""Tests the humanoid's programs, and a whole mission of them: a minute of the robot's life in a second."""

import pytest
from humanoid.arm.server import ArmActionServer
from humanoid.battery.service import BatteryService
from humanoid.joints.service import JointStateService
from humanoid.mission.events import Finished
from humanoid.mission.program import carry_out
from humanoid.mission.robot import Robot
from humanoid.mission.steps import steps
from humanoid.navigation.server import NavigationActionServer
from nav_msgs.msg import Odometry


def test_the_base_drives_at_the_speed_it_is_allowed(gw_clock, gw_graph):
    odometry = gw_graph.record(Odometry, 'odom')
    gw_graph.start(NavigationActionServer)
    with Robot() as robot, robot.drive(24.0, 0.0, allowed=60.0, timeout=60.0) as run:
        left = [feedback.distance_remaining for feedback in run.feedback()]
    assert run.status == 'SUCCEEDED'
    assert gw_clock.elapsed == pytest.approx(30.0, abs=0.1)  # 0.8 m/s
    assert len(left) == pytest.approx(300, abs=5)  # 10 Hz
    assert len(odometry.messages) == pytest.approx(1500, abs=5)  # 50 Hz
    assert left == sorted(left, reverse=True)


def test_the_mission_goes_as_it_should(gw_clock, gw_graph):
    for server in (JointStateService, NavigationActionServer, ArmActionServer, BatteryService):
        gw_graph.start(server)
    events = []
    with Robot() as robot:
        carry_out(robot, steps(), events.append)
    ended = [event for event in events if isinstance(event, Finished)]
    assert [(event.number, event.ok) for event in ended] == [(number, True) for number in range(1, 11)], ended
    assert 10.0 < gw_clock.elapsed < 30.0
