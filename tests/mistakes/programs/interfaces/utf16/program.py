# The definition was saved as UTF-16.
# says: lamp_interfaces/msg/Lamp.msg:1:1: this line is not UTF-8 text: save the file as UTF-8
from lamp_interfaces.msg import Lamp  # <-- here
