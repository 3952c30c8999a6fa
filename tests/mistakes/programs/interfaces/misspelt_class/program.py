# The class is misspelt.
# says: cannot import name 'LightSwich' from lamp_interfaces.srv: there is no srv/LightSwich.srv in lamp_interfaces; did you mean LightSwitch?
from lamp_interfaces.srv import LightSwich  # <-- here
