# A text gets None.
# says: std_msgs/msg/String: data: expected str, got NoneType None (write '')
import rclpy
from std_msgs.msg import String

rclpy.init()
node = rclpy.create_node('talker')
publisher = node.create_publisher(String, 'chatter', 10)
publisher.publish(String(data=None))  # <-- here
