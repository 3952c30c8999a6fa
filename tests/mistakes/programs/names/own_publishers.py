# A node keeps its publishers as self.publishers.
# says: 'publishers' is a property of every Node, and cannot be set: give this attribute of Choir another name, such as 'self.my_publishers'
import rclpy
from rclpy.node import Node
from std_msgs.msg import String


class Choir(Node):
    def __init__(self):
        super().__init__('choir')
        self.publishers = []  # <-- here


rclpy.init()
Choir()
