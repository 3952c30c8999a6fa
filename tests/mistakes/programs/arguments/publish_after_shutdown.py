# A message is published after rclpy.shutdown().
# says: cannot publish on '/chatter': the context was shut down; do this before, or ask rclpy.ok() first
import rclpy
from std_msgs.msg import String

rclpy.init()
node = rclpy.create_node('talker')
publisher = node.create_publisher(String, 'chatter', 10)
rclpy.shutdown()
publisher.publish(String(data='hello'))  # <-- here
