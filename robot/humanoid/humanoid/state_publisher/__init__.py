"""The robot's description, and where its links are: what robot_state_publisher does."""
