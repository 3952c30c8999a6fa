# A launch file starts a program that its package does not have.
# says: executable 'talkr' not found
# at: lamp.launch.xml:2
ros2 launch lamp.launch.xml
