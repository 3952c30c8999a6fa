"""Servers that live by a simulation's /clock: their timers too."""

from __future__ import annotations

from collections import defaultdict

from builtin_interfaces.msg import Time
from diagnostic_msgs.msg import DiagnosticArray
from goalwire.testing import Graph
from helpers.patience import wait_for
from rclpy.parameter import Parameter
from rosgraph_msgs.msg import Clock

from humanoid.arm.server import ArmActionServer
from humanoid.battery.service import BatteryService
from humanoid.joints.service import JointStateService
from humanoid.navigation.server import NavigationActionServer

SERVERS = (JointStateService, NavigationActionServer, BatteryService, ArmActionServer)
BEGINS = 100  # s, of the simulation


def test_what_comes_once_a_second_comes_once_a_simulated_second(gw_graph: Graph) -> None:
    for kind in SERVERS:
        node = gw_graph.start(kind)
        assert node.set_parameters([Parameter('use_sim_time', value=True)])[0].successful
    clock = gw_graph.publisher(Clock, '/clock')
    clock.wait_for_subscriber()
    health = gw_graph.record(DiagnosticArray, '/diagnostics')

    def told() -> dict[str, list[int]]:
        """The simulated seconds at which each server has told of its health."""
        found = defaultdict(list)
        for array in health.messages:
            if BEGINS <= array.header.stamp.sec < 2 * BEGINS:
                found[array.status[0].name].append(array.header.stamp.sec)
        return found

    clock.publish(clock=Time(sec=BEGINS))
    for now in range(BEGINS + 1, BEGINS + 5):
        clock.publish(clock=Time(sec=now))
        wait_for(lambda: [times[-1] for times in told().values()] == [now] * len(SERVERS), f'{now} s')  # noqa: B023
    assert all(times[-4:] == list(range(BEGINS + 1, BEGINS + 5)) for times in told().values())
