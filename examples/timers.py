"""Timers: one that repeats, one that fires once, one that is paused and goes on.

python examples/timers.py
"""

import rclpy
from rclpy.executors import ExternalShutdownException
from rclpy.node import Node


class Timers(Node):
    def __init__(self):
        super().__init__('timers')
        self.ticks = 0
        self.ticking = self.create_timer(0.2, self.tick)
        self.pause = self.create_timer(1.1, self.stop_for_a_while)
        self.resume = self.create_timer(2.0, self.go_on)
        self.resume.cancel()  # reset() starts it

    def tick(self):
        self.ticks += 1
        self.get_logger().info(f'Tick {self.ticks}')

    def stop_for_a_while(self):
        self.pause.cancel()  # a timer that cancels itself has fired once
        self.ticking.cancel()
        self.resume.reset()
        self.get_logger().info('Paused for two seconds')

    def go_on(self):
        self.resume.cancel()
        self.ticking.reset()  # a whole period from now
        self.get_logger().info('Going on')


def main():
    rclpy.init()
    try:
        rclpy.spin(Timers())
    except (KeyboardInterrupt, ExternalShutdownException):
        pass
    finally:
        rclpy.try_shutdown()


if __name__ == '__main__':
    main()
