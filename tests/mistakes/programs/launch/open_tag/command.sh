# A tag of a launch file is never closed.
# says: lamp.launch.xml:6: no valid XML: mismatched tag; <group> of line 2 is open: write </group> where it ends
# at: lamp.launch.xml:6
ros2 launch lamp.launch.xml
