"""The turtle simulator of ROS 2's tutorials, with its window in a browser: package `turtlesim`."""
