"""Two nodes in one process, run by one executor: a sensor and the alarm that listens to it.

python examples/composed.py
"""

import rclpy
from rclpy.executors import ExternalShutdownException, SingleThreadedExecutor
from rclpy.node import Node
from sensor_msgs.msg import Temperature


class Thermometer(Node):
    def __init__(self):
        super().__init__('thermometer')
        self.degrees = 20.0
        self.publisher = self.create_publisher(Temperature, 'temperature', 10)
        self.create_timer(0.2, self.measure)

    def measure(self):
        message = Temperature(temperature=self.degrees)
        message.header.stamp = self.get_clock().now().to_msg()
        self.publisher.publish(message)
        self.degrees += 5.0


class Alarm(Node):
    def __init__(self):
        super().__init__('alarm')
        self.create_subscription(Temperature, 'temperature', self.judge, 10)

    def judge(self, message):
        if message.temperature < 30.0:
            self.get_logger().info(f'{message.temperature} degrees')
        else:
            self.get_logger().warning(f'{message.temperature} degrees: too hot', once=True)


def main():
    rclpy.init()
    try:
        executor = SingleThreadedExecutor()
        for node in (Thermometer(), Alarm()):
            executor.add_node(node)
        executor.spin()
    except (KeyboardInterrupt, ExternalShutdownException):
        pass
    finally:
        rclpy.try_shutdown()


if __name__ == '__main__':
    main()
