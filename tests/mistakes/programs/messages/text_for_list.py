# A list of texts gets one text.
# says: sensor_msgs/msg/JointState: name: expected a list, got str 'left_knee': where the program sets this field, write message.name = ['left_knee']
import rclpy
from sensor_msgs.msg import JointState

rclpy.init()
node = rclpy.create_node('joints')
publisher = node.create_publisher(JointState, 'joint_states', 10)
message = JointState()
message.name = 'left_knee'
publisher.publish(message)  # <-- here
