# The data of ros2 topic pub has no blank after the colon.
# says: ros2: std_msgs/msg/String: 'data:hi' has no blank behind the colon; write 'data: hi'
ros2 topic pub --once /chatter std_msgs/msg/String '{data:hi}'
