# A field's name has a capital letter.
# says: lamp_interfaces/msg/Lamp.msg:1:9: 'maxBrightness' is not a field name (a-z, 0-9 and single _, starting with a letter); write max_brightness
from lamp_interfaces.msg import Lamp  # <-- here
