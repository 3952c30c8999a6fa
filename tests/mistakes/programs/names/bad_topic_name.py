# A topic's name has a hyphen.
# says: Invalid topic name: topic name must not contain characters other than alphanumerics, '_', '~', '{', or '}': 'left-knee' ^ use letters, digits and '_', and begin with a letter: write 'left_knee'
import rclpy
from std_msgs.msg import String

rclpy.init()
node = rclpy.create_node('talker')
node.create_publisher(String, 'left-knee', 10)  # <-- here
