# generate_launch_description() returns nothing.
# says: lamp.launch.py: generate_launch_description() returned NoneType, not a LaunchDescription: write 'return LaunchDescription([…])'
# at: lamp.launch.py
ros2 launch lamp.launch.py
