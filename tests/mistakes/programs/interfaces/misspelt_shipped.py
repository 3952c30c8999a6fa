# A shipped class is misspelt.
# says: did you mean String?
from std_msgs.msg import Sting  # <-- here
