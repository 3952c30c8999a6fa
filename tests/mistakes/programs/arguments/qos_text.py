# The QoS is a text.
# says: Expected QoSProfile or int, but received 'reliable': give the number of messages that are kept, such as 10
import rclpy
from std_msgs.msg import String

rclpy.init()
node = rclpy.create_node('talker')
node.create_publisher(String, 'chatter', 'reliable')  # <-- here
