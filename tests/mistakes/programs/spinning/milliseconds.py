# The timer's period is negative.
# says: failed to create timer: timer period must be non-negative got -1; give the period in seconds, such as 0.5
import rclpy

rclpy.init()
node = rclpy.create_node('talker')
node.create_timer(-1, print)  # <-- here
