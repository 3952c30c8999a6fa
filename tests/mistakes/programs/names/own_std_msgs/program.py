# The student's own file is called std_msgs.py.
# says: hides the package 'std_msgs': give this file another name
import rclpy
from std_msgs.msg import String  # <-- here
