# The publisher keeps its last message, and a late subscription does not ask for it.
# says: topic '/map': the subscription in node '/viewer' came after the last message and does not get it, since that subscription is VOLATILE: if it needs it, write durability=DurabilityPolicy.TRANSIENT_LOCAL in its QoSProfile, as the publisher has it
# within: 4 s
# ctrl-c: yes
import rclpy
from rclpy.qos import DurabilityPolicy, QoSProfile
from std_msgs.msg import String

rclpy.init()
node = rclpy.create_node('viewer')
kept = QoSProfile(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL)
publisher = node.create_publisher(String, 'map', kept)  # <-- here
publisher.publish(String(data='kitchen'))
node.create_subscription(String, 'map', print, 10)
rclpy.spin(node)
