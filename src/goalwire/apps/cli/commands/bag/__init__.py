"""ros2 bag: record, play, info and what else is done with bags."""
