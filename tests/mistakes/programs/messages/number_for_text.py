# A text gets a number.
# says: std_msgs/msg/String: data: expected str, got int 5 (write '5')
import rclpy
from std_msgs.msg import String

rclpy.init()
node = rclpy.create_node('talker')
publisher = node.create_publisher(String, 'chatter', 10)
publisher.publish(String(data=5))  # <-- here
