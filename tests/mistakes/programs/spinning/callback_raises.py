# A callback raises.
# says: 'Talker' object has no attribute 'count' this Talker has no 'count' yet: write 'self.count = …' in Talker.__init__()
import rclpy
from rclpy.node import Node


class Talker(Node):
    def __init__(self):
        super().__init__('talker')
        self.create_timer(0.1, self.talk)

    def talk(self):
        self.count += 1  # <-- here


rclpy.init()
rclpy.spin(Talker())
