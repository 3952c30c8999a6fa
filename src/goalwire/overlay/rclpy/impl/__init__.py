"""rclpy.impl: the parts that rclpy's public modules re-export."""
