"""The turtle simulator of ROS 2's first pages, its window in a browser: package `turtlesim`."""
