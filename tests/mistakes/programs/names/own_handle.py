# A node keeps something of its own as self.handle.
# says: 'handle' is a property of every Node, and cannot be set: give this attribute of Door another name, such as 'self.my_handle'
import rclpy
from rclpy.node import Node


class Door(Node):
    def __init__(self):
        super().__init__('door')
        self.handle = 'left'  # <-- here


rclpy.init()
Door()
