"""rclpy.impl: the implementation of what rclpy's public modules re-export."""
