# A line ends with a semicolon.
# says: lamp_interfaces/msg/Lamp.msg:1:9: 'brightness;' is not a field name (a-z, 0-9 and single _, starting with a letter); write brightness
from lamp_interfaces.msg import Lamp  # <-- here
