# A noun of ros2 is misspelt.
# says: ros2: there is no command 'topics'; did you mean 'topic' or 'top'? see: ros2 --help
ros2 topics list
