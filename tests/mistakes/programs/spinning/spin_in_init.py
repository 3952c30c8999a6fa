# rclpy.spin(self) stands in __init__, before the timer is made.
# says: rclpy.spin(self) in Talker.__init__() runs a node that has no callbacks yet, and the lines behind it wait until the end: leave it out, and call rclpy.spin(node) when Talker() has been made
# ctrl-c: yes
import rclpy
from rclpy.node import Node


class Talker(Node):
    def __init__(self):
        super().__init__('talker')
        rclpy.spin(self)  # <-- here
        self.create_timer(0.5, self.talk)

    def talk(self):
        print('hello')


rclpy.init()
Talker()
