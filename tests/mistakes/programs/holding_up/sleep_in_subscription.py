# A subscription's callback sleeps while a timer waits.
# says: the callback Robot.hear() has not returned for seconds, and other callbacks wait for it: let it return, and do the rest in a timer or in a thread; or spin with a MultiThreadedExecutor and give it a callback group of its own
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
