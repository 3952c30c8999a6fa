# create_publisher() gets no QoS.
# says: Node.create_publisher() missing 1 required positional argument: 'qos_profile' give the number of messages that are kept as the last argument, such as 10
import rclpy
from std_msgs.msg import String

rclpy.init()
node = rclpy.create_node('talker')
node.create_publisher(String, 'chatter')  # <-- here
