# ros2 topic pub gets a type without msg.
# says: ros2: there is no type 'std_msgs/msg/Sting' here; did you mean 'std_msgs/msg/String' or 'std_msgs/msg/Int8' or 'std_msgs/msg/Byte'?
ros2 topic pub --once /chatter std_msgs/Sting '{data: hi}'
