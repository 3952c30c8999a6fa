# A nested message gets a number.
# says: geometry_msgs/msg/Twist: linear: expected Vector3, got float 1.0: where the program sets this field, write message.linear.x = 1.0
import rclpy
from geometry_msgs.msg import Twist

rclpy.init()
node = rclpy.create_node('driver')
publisher = node.create_publisher(Twist, 'cmd_vel', 10)
twist = Twist()
twist.linear = 1.0
publisher.publish(twist)  # <-- here
