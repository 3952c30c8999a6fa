"""Joint states without a robot: packages `joint_state_publisher` and `joint_state_publisher_gui`."""
