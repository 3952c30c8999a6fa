# The package's name differs in package.xml.
# says: lamp_interfaces/package.xml names the package lamp_interface: write <name>lamp_interfaces</name>
from lamp_interfaces.srv import LightSwitch  # <-- here
