# A message is published after the node was destroyed.
# says: cannot publish on '/chatter' because destruction was requested: destroy_node() of its node was called before; call publish() before that
import rclpy
from std_msgs.msg import String

rclpy.init()
node = rclpy.create_node('talker')
publisher = node.create_publisher(String, 'chatter', 10)
node.destroy_node()
publisher.publish(String(data='hello'))  # <-- here
