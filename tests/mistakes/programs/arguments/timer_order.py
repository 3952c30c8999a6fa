# The callback stands before the period.
# says: the period of a timer is a number of seconds and stands before the callback: create_timer(0.5, callback)
import rclpy

rclpy.init()
node = rclpy.create_node('talker')
node.create_timer(print, 0.5)  # <-- here
