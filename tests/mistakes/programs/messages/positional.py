# A field is given without its name.
# says: String.__init__() takes 1 positional argument but 2 were given give each field its name: write String(data=…)
import rclpy
from std_msgs.msg import String

rclpy.init()
message = String('hello')  # <-- here
