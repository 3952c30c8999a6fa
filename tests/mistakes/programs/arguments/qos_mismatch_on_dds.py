# A reliable subscription meets a best-effort publisher on DDS.
# says: New subscription discovered on topic 'chatter', requesting incompatible QoS. No messages will be sent to it. Last incompatible policy: RELIABILITY; write reliability=ReliabilityPolicy.RELIABLE in the QoSProfile of the publisher, or BEST_EFFORT in that of the subscription
# ctrl-c: yes
import os

import rclpy
from rclpy.qos import QoSProfile, ReliabilityPolicy
from std_msgs.msg import String

os.environ['RMW_IMPLEMENTATION'] = 'rmw_fastrtps_cpp'
rclpy.init()
node = rclpy.create_node('talker')
best_effort = QoSProfile(depth=10, reliability=ReliabilityPolicy.BEST_EFFORT)
reliable = QoSProfile(depth=10, reliability=ReliabilityPolicy.RELIABLE)
node.create_publisher(String, 'chatter', best_effort)  # <-- here
node.create_subscription(String, 'chatter', print, reliable)
rclpy.spin(node)
