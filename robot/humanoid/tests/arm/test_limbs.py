"""When the joints count as lost."""

from __future__ import annotations

from unittest.mock import Mock

from sensor_msgs.msg import JointState

from humanoid.arm.limbs import TICK, Limbs


def test_looks_without_a_joint_state_are_counted_and_not_the_time_of_a_server_that_was_held_up() -> None:
    node = Mock()
    limbs = Limbs(node, lambda: None)
    lost = [limbs.are_lost]
    node.get_clock().now().nanoseconds = 0
    limbs._see(JointState(name=['left_arm_elbow'], position=[0.0]))
    node.get_clock().now().nanoseconds = 10_000_000_000  # the server was held up for 10 s
    limbs.look()
    lost.append(limbs.are_lost)
    for _ in range(round(1.0 / TICK)):
        limbs.look()
    lost.append(limbs.are_lost)
    limbs._see(JointState(name=['left_arm_elbow'], position=[0.0]))
    lost.append(limbs.are_lost)
    assert lost == [True, False, True, False]
