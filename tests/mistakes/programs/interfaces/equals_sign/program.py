# A field is given a default value with an equals sign.
# says: lamp_interfaces/msg/Lamp.msg:1:7: 'a' is not a constant name (A-Z, 0-9 and single _); for a field with a default value write no '=': int32 a 3
from lamp_interfaces.msg import Lamp  # <-- here
