# A service has no line of dashes.
# says: lamp_interfaces/srv/LightSwitch.srv:1:1: found 0 separator lines '---', a .srv has 1: request --- response; write each on a line of its own
from lamp_interfaces.srv import LightSwitch  # <-- here
