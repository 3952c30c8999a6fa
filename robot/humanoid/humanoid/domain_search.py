"""Checks if one of the humanoid's servers is in this ROS domain; humanoid.domain runs this program."""

from __future__ import annotations

LOOK_FOR = 1.0  # s for the discovery of the domain's servers
SOMEBODY_IS_THERE = 3  # the exit code if a server is there; else it is 0


def main() -> int:
    import rclpy
    from humanoid_interfaces.action import MoveArm, MoveToPosition
    from humanoid_interfaces.srv import GetBatteryStatus, GetJointState
    from rclpy.action import ActionClient

    rclpy.init(args=[])
    node = rclpy.create_node('humanoid_look')
    joints = node.create_client(GetJointState, 'get_joint_state')
    battery = node.create_client(GetBatteryStatus, 'get_battery_status')
    base = ActionClient(node, MoveToPosition, 'move_to_position')
    arm = ActionClient(node, MoveArm, 'move_arm')
    seen = (
        joints.wait_for_service(timeout_sec=LOOK_FOR)  # by then the other servers are discovered, too
        or battery.service_is_ready()
        or base.server_is_ready()
        or arm.server_is_ready()
    )
    base.destroy()
    arm.destroy()
    node.destroy_node()
    rclpy.shutdown()
    return SOMEBODY_IS_THERE if seen else 0


if __name__ == '__main__':
    raise SystemExit(main())
