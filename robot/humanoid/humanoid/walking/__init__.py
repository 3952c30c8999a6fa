"""Standing and walking: computes motor torques from sensors. Independent of ROS and of the simulation."""
