"""ros2 doctor."""
