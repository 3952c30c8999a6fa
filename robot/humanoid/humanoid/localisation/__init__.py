"""Where the robot is on its map: scans are matched with the map, and odometry is corrected by that."""
