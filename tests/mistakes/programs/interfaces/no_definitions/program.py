# A distribution registers its interfaces, and does not contain them.
# says: entry point goalwire.interfaces: lamp_interfaces = lamp_definitions leads to no folder with msg/, srv/ or action/; it is passed over
from lamp_interfaces.srv import LightSwitch  # <-- here
