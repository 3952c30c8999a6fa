# rclpy.init() is not called.
# says: rclpy.init() has not been called. msg:cannot create node call rclpy.init() before this line; after rclpy.shutdown(), call it again
from rclpy.node import Node

node = Node('talker')  # <-- here
