# The definition lies beside package.xml, and in no folder srv.
# says: LightSwitch.srv lies beside lamp_interfaces/package.xml: move it to lamp_interfaces/srv/LightSwitch.srv
from lamp_interfaces.srv import LightSwitch  # <-- here
