# The topic stands before the type.
# says: a class of a message, a service or an action is needed: 'chatter' is a text: write the class first and then the name, as in (CLASS, 'chatter', …)
import rclpy
from std_msgs.msg import String

rclpy.init()
node = rclpy.create_node('talker')
node.create_publisher('chatter', String, 10)  # <-- here
