"""The mission: a list of steps that together use every service and action of the robot."""
