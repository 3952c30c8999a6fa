"""A node that lives in simulated time: its timers, its sleep and its stamps follow /clock.

python examples/sim_time.py --ros-args -p use_sim_time:=true
python examples/clock_publisher.py      # in another terminal
"""

import rclpy
from rclpy.callback_groups import MutuallyExclusiveCallbackGroup
from rclpy.clock import JumpThreshold
from rclpy.duration import Duration
from rclpy.executors import ExternalShutdownException, MultiThreadedExecutor
from rclpy.node import Node


class SimTime(Node):
    def __init__(self):
        super().__init__('sim_time')
        self.clock = self.get_clock()
        how = 'simulated' if self.clock.ros_time_is_active else "the machine's"
        self.get_logger().info(f'The time is {how}')
        self.create_timer(1.0, self.tick)
        back = JumpThreshold(min_forward=None, min_backward=Duration(nanoseconds=-1))
        self.jump = self.clock.create_jump_callback(back, post_callback=self.time_went_back)
        self.nap = self.create_timer(2.5, self.sleep, MutuallyExclusiveCallbackGroup())

    def tick(self):
        self.get_logger().info(f'It is second {self.clock.now().nanoseconds // 10**9}')

    def sleep(self):
        self.nap.cancel()
        begun = self.clock.now()
        self.clock.sleep_for(Duration(seconds=2))
        slept = (self.clock.now() - begun).nanoseconds / 1e9
        self.get_logger().info(f'Slept {slept:.0f} seconds')

    def time_went_back(self, jump):
        self.get_logger().warning(f'Time went back by {-jump.delta.nanoseconds / 1e9:.1f} seconds')


def main():
    rclpy.init()
    try:
        rclpy.spin(SimTime(), MultiThreadedExecutor())  # one thread may sleep
    except (KeyboardInterrupt, ExternalShutdownException):
        pass
    finally:
        rclpy.try_shutdown()


if __name__ == '__main__':
    main()
