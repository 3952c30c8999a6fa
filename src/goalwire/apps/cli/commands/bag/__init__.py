"""ros2 bag: record, play, info and other work with bags."""
