# A launch file in Python has no generate_launch_description().
# says: lamp.launch.py does not define generate_launch_description(): write a function of that name, which returns a LaunchDescription
# at: lamp.launch.py
ros2 launch lamp.launch.py
