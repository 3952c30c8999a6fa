# A field's name is misspelt in the constructor.
# says: Invalid arguments passed to constructor: liner; Twist has no such field, did you mean linear?
import rclpy
from geometry_msgs.msg import Twist, Vector3

rclpy.init()
twist = Twist(liner=Vector3(x=1.0))  # <-- here
