"""Makes simulated time, ten seconds in each real one, as a simulator or a player of recordings does.

python examples/clock_publisher.py
python examples/sim_time.py --ros-args -p use_sim_time:=true      # in another terminal
"""

import rclpy
from rclpy.clock import Clock, ClockType
from rclpy.duration import Duration
from rclpy.executors import ExternalShutdownException
from rclpy.node import Node
from rclpy.time import Time
from rosgraph_msgs.msg import Clock as ClockMessage


class ClockPublisher(Node):
    def __init__(self):
        super().__init__('clock_publisher')
        self.time = Time(seconds=100)
        self.step = Duration(seconds=0.1)
        self.publisher = self.create_publisher(ClockMessage, '/clock', 10)
        # A node that makes the time must not wait for it: this timer goes by the machine's clock.
        self.create_timer(0.01, self.tick, clock=Clock(clock_type=ClockType.STEADY_TIME))
        self.get_logger().info('Time begins')

    def tick(self):
        self.time += self.step
        self.publisher.publish(ClockMessage(clock=self.time.to_msg()))


def main():
    rclpy.init()
    try:
        rclpy.spin(ClockPublisher())
    except (KeyboardInterrupt, ExternalShutdownException):
        pass
    finally:
        rclpy.try_shutdown()


if __name__ == '__main__':
    main()
