# The data of ros2 topic pub has a misspelt field.
# says: ros2: std_msgs/msg/String has no field 'dat'; did you mean 'data'? see: ros2 interface show std_msgs/msg/String
ros2 topic pub --once /chatter std_msgs/msg/String '{dat: hi}'
