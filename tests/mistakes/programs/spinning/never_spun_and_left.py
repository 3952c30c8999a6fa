# The node is never spun, and nothing is shut down.
# says: node '/listener' was never spun, so its callbacks never ran (1 subscription): call rclpy.spin(node) after you have made it
import rclpy
from std_msgs.msg import String

rclpy.init()
node = rclpy.create_node('listener')  # <-- here
node.create_subscription(String, 'chatter', print, 10)
