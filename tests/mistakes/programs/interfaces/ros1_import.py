# A class is imported as in ROS 1.
# says: cannot import name 'String' from 'std_msgs': types are one level below; write: from std_msgs.msg import String
from std_msgs import String  # <-- here
