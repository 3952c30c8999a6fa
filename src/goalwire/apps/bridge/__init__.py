"""Bridges between web sockets and the ROS graph, for programs that do not use ROS 2 themselves."""
