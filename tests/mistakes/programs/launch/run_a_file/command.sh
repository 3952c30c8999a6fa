# ros2 run gets a file.
# says: ros2 run: 'node.py' is a file, and a package and its executable are needed; to run a file: python3 node.py
ros2 run node.py
