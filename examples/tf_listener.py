"""Asks where the moon is, seen from the sun. Its other half is tf_broadcaster.py.

python examples/tf_listener.py
"""

import math

import rclpy
from rclpy.executors import ExternalShutdownException
from rclpy.node import Node
from rclpy.time import Time
from tf2_ros import TransformException
from tf2_ros.buffer import Buffer
from tf2_ros.transform_listener import TransformListener


class Astronomer(Node):
    def __init__(self):
        super().__init__('astronomer')
        self.buffer = Buffer()
        self.listener = TransformListener(self.buffer, self)
        self.create_timer(0.2, self.look)

    def look(self):
        try:
            found = self.buffer.lookup_transform('sun', 'moon', Time())  # the latest there is
        except TransformException as error:
            self.get_logger().info(f'Not seen yet: {error}')
            return
        place = found.transform.translation
        from_earth = math.hypot(place.x - 10.0, place.y)
        self.get_logger().info(
            f'The moon is at {place.x:.2f}, {place.y:.2f}: {from_earth:.1f} from the earth'
        )


def main():
    rclpy.init()
    try:
        rclpy.spin(Astronomer())
    except (KeyboardInterrupt, ExternalShutdownException):
        pass
    finally:
        rclpy.try_shutdown()


if __name__ == '__main__':
    main()
