# The callback stands last in create_subscription().
# says: Expected QoSProfile or int, but received print: the callback stands before it: create_subscription(String, topic, callback, 10)
import rclpy
from std_msgs.msg import String

rclpy.init()
node = rclpy.create_node('listener')
node.create_subscription(String, 'chatter', 10, print)  # <-- here
