# A field has the type Header.
# says: lamp_interfaces/msg/Lamp.msg:1:1: field header: lamp_interfaces/msg/Header: the package has no such type in lamp_interfaces; write std_msgs/Header
from lamp_interfaces.msg import Lamp  # <-- here
