# A node keeps something of its own as self.executor.
# says: 'executor' is a property of every Node, and cannot be set: give this attribute of Robot another name, such as 'self.my_executor'
import rclpy
from rclpy.node import Node


class Robot(Node):
    def __init__(self):
        super().__init__('robot')
        self.executor = 'arm'  # <-- here


rclpy.init()
Robot()
