# A callback sleeps under a MultiThreadedExecutor, in the same group as a timer.
# says: and other callbacks wait for it: callbacks of one callback group never run at the same time, even with a MultiThreadedExecutor: where the program creates the subscription, timer or service of hear(), write callback_group=MutuallyExclusiveCallbackGroup(), from rclpy.callback_groups
# within: 4 s
# ctrl-c: yes
import time

import rclpy
from rclpy.executors import MultiThreadedExecutor
from rclpy.node import Node
from std_msgs.msg import Empty


class Robot(Node):
    def __init__(self):
        super().__init__('robot')
        self.create_timer(0.2, self.blink)
        self.create_subscription(Empty, 'go', self.hear, 10)
        self.create_publisher(Empty, 'go', 10).publish(Empty())

    def blink(self):
        pass

    def hear(self, message):
        time.sleep(8)  # <-- here


rclpy.init()
executor = MultiThreadedExecutor()
executor.add_node(Robot())
executor.spin()
