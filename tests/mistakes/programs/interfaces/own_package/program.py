# A field names a type that its package does not have.
# says: lamp_interfaces/msg/Lamp.msg:1:1: field pose: lamp_interfaces/msg/PoseStamped: the package has no such type in lamp_interfaces; write geometry_msgs/PoseStamped
from lamp_interfaces.msg import Lamp  # <-- here
