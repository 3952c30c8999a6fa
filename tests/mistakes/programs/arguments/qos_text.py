# The QoS is a text.
# says: Expected QoSProfile or int, but received 'reliable': write 10, the number of messages that are kept (it is reliable then), or QoSProfile(depth=10, …), from rclpy.qos
import rclpy
from std_msgs.msg import String

rclpy.init()
node = rclpy.create_node('talker')
node.create_publisher(String, 'chatter', 'reliable')  # <-- here
