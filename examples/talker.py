"""Publishes a greeting every half second on the topic `chatter`. Its other half is listener.py.

python examples/talker.py
python examples/talker.py --ros-args -r chatter:=news
"""

import rclpy
from rclpy.executors import ExternalShutdownException
from rclpy.node import Node
from std_msgs.msg import String


class Talker(Node):
    def __init__(self):
        super().__init__('talker')
        self.count = 0
        self.publisher = self.create_publisher(String, 'chatter', 10)
        self.create_timer(0.5, self.talk)

    def talk(self):
        self.count += 1
        message = String(data=f'Hello number {self.count}')
        self.publisher.publish(message)
        self.get_logger().info(f'Said: {message.data}')


def main():
    rclpy.init()
    try:
        rclpy.spin(Talker())
    except (KeyboardInterrupt, ExternalShutdownException):
        pass
    finally:
        rclpy.try_shutdown()


if __name__ == '__main__':
    main()
