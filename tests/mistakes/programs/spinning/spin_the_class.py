# rclpy.spin() gets the class and not a node.
# says: a node is needed, got the class: write Talker(), with the parentheses
import rclpy
from rclpy.node import Node


class Talker(Node):
    def __init__(self):
        super().__init__('talker')


rclpy.init()
rclpy.spin(Talker)  # <-- here
