"""make bench-peers: goalwire beside what else pip installs for ROS 2, each by a program in its own style."""
