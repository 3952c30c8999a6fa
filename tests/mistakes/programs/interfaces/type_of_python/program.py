# A field has a type of Python.
# says: lamp_interfaces/msg/Lamp.msg:1:1: 'float' is not a type (write float32)
from lamp_interfaces.msg import Lamp  # <-- here
