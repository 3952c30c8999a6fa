# Two callbacks loop under a MultiThreadedExecutor with two threads, and a timer waits.
# says: and other callbacks wait for it: the executor has 2 threads, and all are in callbacks: let them return, or write MultiThreadedExecutor(num_threads=…) with a larger number
# within: 4 s
# ctrl-c: yes
import time

import rclpy
from rclpy.callback_groups import ReentrantCallbackGroup
from rclpy.executors import MultiThreadedExecutor
from rclpy.node import Node


class Robot(Node):
    def __init__(self):
        super().__init__('robot')
        group = ReentrantCallbackGroup()
        self.create_timer(0.2, self.look, callback_group=group)
        self.create_timer(0.3, self.blink, callback_group=group)

    def look(self):
        while rclpy.ok():
            time.sleep(0.1)  # <-- here

    def blink(self):
        pass


rclpy.init()
executor = MultiThreadedExecutor(num_threads=2)
executor.add_node(Robot())
executor.spin()
