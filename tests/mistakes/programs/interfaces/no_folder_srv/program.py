# The definition lies beside package.xml, and in no folder srv.
# says: LightSwitch.srv lies beside lamp_interfaces/package.xml: move it into a folder srv
from lamp_interfaces.srv import LightSwitch  # <-- here
