# A node keeps something of its own as self._parameters, which rclpy allows.
# says: the heat is 180.0
import rclpy
from rclpy.node import Node


class Oven(Node):
    def __init__(self):
        super().__init__('oven')
        self._parameters = {}
        self.declare_parameter('heat', 180.0)
        print('the heat is', self.get_parameter('heat').value)


rclpy.init()
Oven()
