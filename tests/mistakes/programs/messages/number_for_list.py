# A list gets one number.
# says: The 'position' field: a list is needed, got 0.5: write position=[0.5]
import rclpy
from sensor_msgs.msg import JointState

rclpy.init()
node = rclpy.create_node('joints')
publisher = node.create_publisher(JointState, 'joint_states', 10)
publisher.publish(JointState(name=['knee'], position=0.5))  # <-- here
