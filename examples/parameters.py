"""Parameters: declared with a default, given on the command line, changed by the program itself.

python examples/parameters.py
python examples/parameters.py --ros-args -p whom:=moon -p period:=0.2
"""

import rclpy
from rclpy.executors import ExternalShutdownException
from rclpy.node import Node
from rclpy.parameter import Parameter


class Greeter(Node):
    def __init__(self):
        super().__init__('greeter')
        self.declare_parameter('whom', 'world')
        self.declare_parameter('period', 1.0)
        [answer] = self.set_parameters([Parameter('whom', value=42)])
        self.get_logger().info(f'Whom to greet stays a string: {answer.reason}')
        self.create_timer(self.get_parameter('period').value, self.greet)

    def greet(self):
        whom = self.get_parameter('whom').value
        self.get_logger().info(f'Hello {whom}')
        self.set_parameters([Parameter('whom', value=f'{whom}!')])


def main():
    rclpy.init()
    try:
        rclpy.spin(Greeter())
    except (KeyboardInterrupt, ExternalShutdownException):
        pass
    finally:
        rclpy.try_shutdown()


if __name__ == '__main__':
    main()
