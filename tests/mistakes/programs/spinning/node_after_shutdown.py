# A node is made after rclpy.shutdown().
# says: rclpy.init() has not been called. msg:cannot create node call rclpy.init() before; rclpy.shutdown() ends what it began
import rclpy

rclpy.init()
rclpy.shutdown()
node = rclpy.create_node('late')  # <-- here
