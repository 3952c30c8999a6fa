# A launch file gets an argument that it does not have.
# says: the launch file has no argument 'robt'; did you mean robot?
ros2 launch lamp.launch.xml robt:=right
