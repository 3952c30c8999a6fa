"""The mission: steps that use every service and action of the robot together."""
