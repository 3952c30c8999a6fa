# A topic's name begins with a digit.
# says: Invalid topic name: topic name token must not start with a number: '2nd_topic' ^ use letters, digits and '_', and begin with a letter: write 'my_2nd_topic'
import rclpy
from std_msgs.msg import String

rclpy.init()
node = rclpy.create_node('talker')
node.create_publisher(String, '2nd_topic', 10)  # <-- here
