# A reliable subscription meets a best-effort publisher.
# says: New subscription discovered on topic 'chatter', requesting incompatible QoS. No messages will be sent to it. Last incompatible policy: RELIABILITY; make the publisher RELIABLE, or the subscription BEST_EFFORT (this is so on DDS; rmw_zenoh_cpp, which runs now, delivers the messages anyway)
# ctrl-c: yes
import rclpy
from rclpy.qos import QoSProfile, ReliabilityPolicy
from std_msgs.msg import String

rclpy.init()
node = rclpy.create_node('talker')
best_effort = QoSProfile(depth=10, reliability=ReliabilityPolicy.BEST_EFFORT)
reliable = QoSProfile(depth=10, reliability=ReliabilityPolicy.RELIABLE)
node.create_publisher(String, 'chatter', best_effort)
node.create_subscription(String, 'chatter', print, reliable)
rclpy.spin(node)
