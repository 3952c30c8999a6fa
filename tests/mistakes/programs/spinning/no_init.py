# rclpy.init() is not called.
# says: rclpy.init() has not been called. msg:cannot create node call rclpy.init() before; rclpy.shutdown() ends what it began
from rclpy.node import Node

node = Node('talker')  # <-- here
