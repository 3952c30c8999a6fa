"""ros2 component."""
