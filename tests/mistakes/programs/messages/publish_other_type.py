# A message of another type is published.
# says: expected std_msgs.msg.String, got std_msgs.msg.Int32: write String(…)
import rclpy
from std_msgs.msg import Int32, String

rclpy.init()
node = rclpy.create_node('talker')
publisher = node.create_publisher(String, 'chatter', 10)
publisher.publish(Int32(data=1))  # <-- here
