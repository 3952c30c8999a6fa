"""Finds the robot on its map: scans are matched with the map, and the result corrects odometry."""
