"""A humanoid robot's services and actions, written for rclpy and nothing else."""
