# A service has no line of dashes.
# says: lamp_interfaces/srv/LightSwitch.srv:1:1: LightSwitch.srv has no line '---': write a line with only --- below the fields of the request; the fields of the response come below it
from lamp_interfaces.srv import LightSwitch  # <-- here
