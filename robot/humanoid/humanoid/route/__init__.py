"""The way through a world: costmaps, planner, follower, and the actions that send the robot somewhere."""
