"""Where rclpy keeps what its public modules re-export."""
