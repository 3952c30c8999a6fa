# A tag of a launch file is misspelt.
# says: lamp.launch.xml:2: unknown tag `nod`; did you mean node?
# at: lamp.launch.xml:2
ros2 launch lamp.launch.xml
