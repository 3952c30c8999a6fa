# A message is published before the subscription is there.
# says: topic '/map': 1 message was published before the subscription in node '/viewer' was there, which does not get it: publish again when it is there, as in a timer, or write durability=DurabilityPolicy.TRANSIENT_LOCAL in the QoSProfile of both, so that the last messages are kept
# within: 4 s
# ctrl-c: yes
import rclpy
from std_msgs.msg import String

rclpy.init()
node = rclpy.create_node('viewer')
publisher = node.create_publisher(String, 'map', 10)  # <-- here
publisher.publish(String(data='kitchen'))
node.create_subscription(String, 'map', print, 10)
rclpy.spin(node)
