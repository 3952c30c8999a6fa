# A reliable subscription meets a best-effort publisher.
# says: New subscription discovered on topic 'chatter', requesting incompatible QoS. With DDS, as on most robots, no messages will be sent to it; with rmw_zenoh_cpp, which runs here, they arrive. Last incompatible policy: RELIABILITY; write reliability=ReliabilityPolicy.RELIABLE in the QoSProfile of the publisher, or BEST_EFFORT in that of the subscription
# ctrl-c: yes
import rclpy
from rclpy.qos import QoSProfile, ReliabilityPolicy
from std_msgs.msg import String

rclpy.init()
node = rclpy.create_node('talker')
best_effort = QoSProfile(depth=10, reliability=ReliabilityPolicy.BEST_EFFORT)
reliable = QoSProfile(depth=10, reliability=ReliabilityPolicy.RELIABLE)
node.create_publisher(String, 'chatter', best_effort)  # <-- here
node.create_subscription(String, 'chatter', print, reliable)
rclpy.spin(node)
