# The package is misspelt.
# says: Did you mean lamp_interfaces
from lamp_interface.srv import LightSwitch  # <-- here
