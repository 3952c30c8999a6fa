# __init__ does not call super().__init__().
# says: Talker is not a node yet: Talker.__init__() must call super().__init__('name') first
import rclpy
from rclpy.node import Node


class Talker(Node):
    def __init__(self):
        self.create_timer(0.5, self.talk)  # <-- here

    def talk(self):
        print('hello')


rclpy.init()
rclpy.spin(Talker())
