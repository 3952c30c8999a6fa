# rclpy.init() is called twice.
# says: Context.init() must only be called once; rclpy.init() was called before: call rclpy.shutdown() first, or leave this call out
import rclpy

rclpy.init()
rclpy.init()  # <-- here
