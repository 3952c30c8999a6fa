# A package is imported that is not installed.
# says: No module named 'fancy_msgs', and no interface package named 'fancy_msgs'.
from fancy_msgs.msg import Hat  # <-- here
