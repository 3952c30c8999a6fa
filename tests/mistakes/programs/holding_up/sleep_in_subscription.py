# A subscription's callback sleeps while a timer waits.
# says: the callback Robot.hear() has not returned for seconds (it is at: time.sleep(20)), and other callbacks wait for it: let it return, and do the rest in a timer, self.create_timer(seconds, self.rest), or in a thread, threading.Thread(target=self.rest).start(); or spin with a MultiThreadedExecutor and give it callback_group=MutuallyExclusiveCallbackGroup()
# within: 5 s
# ctrl-c: yes
import time

import rclpy
from rclpy.node import Node
from std_msgs.msg import String


class Robot(Node):
    def __init__(self):
        super().__init__('robot')
        self.publisher = self.create_publisher(String, 'chatter', 10)
        self.create_subscription(String, 'chatter', self.hear, 10)
        self.create_timer(0.1, self.talk)

    def talk(self):
        self.publisher.publish(String(data='hello'))

    def hear(self, message):
        time.sleep(20)  # <-- here


rclpy.init()
rclpy.spin(Robot())
