"""Finds the robot's pose on the map: laser scans are matched with the map, which corrects odometry."""
