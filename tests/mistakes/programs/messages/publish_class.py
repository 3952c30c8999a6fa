# The class is published and not a message.
# says: expected std_msgs.msg.String, got the class: write String(), with the parentheses
import rclpy
from std_msgs.msg import String

rclpy.init()
node = rclpy.create_node('talker')
publisher = node.create_publisher(String, 'chatter', 10)
publisher.publish(String)  # <-- here
