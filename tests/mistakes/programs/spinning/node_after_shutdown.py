# A node is made after rclpy.shutdown().
# says: rclpy.init() has not been called. msg:cannot create node call rclpy.init() before this line; after rclpy.shutdown(), call it again
import rclpy

rclpy.init()
rclpy.shutdown()
node = rclpy.create_node('late')  # <-- here
