# ros2 run gets a file.
# says: ros2 run: 'node.py' is a file, but a package and an executable are needed; to run a file: python3 node.py
ros2 run node.py
