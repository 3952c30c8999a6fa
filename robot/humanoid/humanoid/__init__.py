"""A humanoid robot's services and actions, written for rclpy alone."""
