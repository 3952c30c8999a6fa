# ros2 topic echo gets the name of a topic that is not there.
# says: ros2: there is no topic '/chater'; see: ros2 topic list
ros2 topic echo /chater
