"""Tells where things are: a moon that circles an earth. Its other half is tf_listener.py.

python examples/tf_broadcaster.py
"""

import math

import rclpy
from geometry_msgs.msg import TransformStamped
from rclpy.executors import ExternalShutdownException
from rclpy.node import Node
from tf2_ros import TransformBroadcaster
from tf2_ros.static_transform_broadcaster import StaticTransformBroadcaster

DISTANCE = 3.0


class Moon(Node):
    def __init__(self):
        super().__init__('moon')
        self.angle = 0.0
        self.broadcaster = TransformBroadcaster(self)
        self.static_broadcaster = StaticTransformBroadcaster(self)
        self.static_broadcaster.sendTransform(self.transform('sun', 'earth', x=10.0))
        self.create_timer(0.05, self.move)
        self.get_logger().info('Circling')

    def move(self):
        self.angle += 0.05
        x, y = DISTANCE * math.cos(self.angle), DISTANCE * math.sin(self.angle)
        self.broadcaster.sendTransform(self.transform('earth', 'moon', x, y, self.angle))

    def transform(self, parent, child, x=0.0, y=0.0, yaw=0.0):
        message = TransformStamped(child_frame_id=child)
        message.header.frame_id = parent
        message.header.stamp = self.get_clock().now().to_msg()
        message.transform.translation.x = x
        message.transform.translation.y = y
        message.transform.rotation.z = math.sin(yaw / 2)
        message.transform.rotation.w = math.cos(yaw / 2)
        return message


def main():
    rclpy.init()
    try:
        rclpy.spin(Moon())
    except (KeyboardInterrupt, ExternalShutdownException):
        pass
    finally:
        rclpy.try_shutdown()


if __name__ == '__main__':
    main()
