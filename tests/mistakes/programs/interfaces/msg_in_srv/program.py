# The class is imported from msg and is in srv.
# says: lamp_interfaces has no msg types (its definitions are in lamp_interfaces); it has some in srv, so import from there
from lamp_interfaces.msg import LightSwitch  # <-- here
