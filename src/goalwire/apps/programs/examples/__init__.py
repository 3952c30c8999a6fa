"""The minimal examples of ROS 2: packages `examples_rclpy_minimal_*`."""
