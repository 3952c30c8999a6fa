# A QoS profile has no depth.
# says: History and/or depth settings are required.') give the number of messages that are kept: write QoSProfile(depth=10, …)
from rclpy.qos import QoSProfile, ReliabilityPolicy

profile = QoSProfile(reliability=ReliabilityPolicy.RELIABLE)  # <-- here
