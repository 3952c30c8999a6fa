# A message is given and not its class.
# says: this is a message of type String: give the class itself, String without ()
import rclpy
from std_msgs.msg import String

rclpy.init()
node = rclpy.create_node('talker')
node.create_publisher(String(), 'chatter', 10)  # <-- here
