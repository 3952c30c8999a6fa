"""Navigation in a world: costmaps, path planner, path follower, and the actions that drive to a goal."""
