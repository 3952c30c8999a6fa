"""The way through a world: costmaps, planner, follower, and the actions that drive the robot to a goal."""
