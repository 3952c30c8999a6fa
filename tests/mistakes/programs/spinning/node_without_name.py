# The node gets no name.
# says: Node.__init__() missing 1 required positional argument: 'node_name' give the node a name: write super().__init__('talker')
import rclpy
from rclpy.node import Node


class Talker(Node):
    def __init__(self):
        super().__init__()  # <-- here


rclpy.init()
Talker()
