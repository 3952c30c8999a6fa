# A field's name is misspelt in an assignment.
# says: Vector3 has the fields x, y, z; did you mean 'x'?
import rclpy
from geometry_msgs.msg import Twist

rclpy.init()
twist = Twist()
twist.linear.X = 1.0  # <-- here
