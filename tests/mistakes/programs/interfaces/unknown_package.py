# A package is imported that is not installed.
# says: If fancy_msgs is your own package, start the program in its workspace, or name its folder in GOALWIRE_INTERFACE_PATH. If others made it, copy its folder, with package.xml, into your workspace.
from fancy_msgs.msg import Hat  # <-- here
