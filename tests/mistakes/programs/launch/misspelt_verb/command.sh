# A verb of ros2 is misspelt.
# says: ros2 topic: there is no verb 'ehco'; did you mean 'echo'? see: ros2 topic --help
ros2 topic ehco /chatter
