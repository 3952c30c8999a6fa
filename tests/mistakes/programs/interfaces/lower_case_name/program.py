# The name of the definition's file is in lower case.
# says: cannot import name 'LightSwitch' from lamp_interfaces.srv: the name of a definition is in CamelCase; rename srv/light_switch.srv in lamp_interfaces to LightSwitch.srv
from lamp_interfaces.srv import LightSwitch  # <-- here
