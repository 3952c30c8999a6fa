"""Bridges: web sockets on one side, the graph on the other, for programs that speak no ROS 2 themselves."""
