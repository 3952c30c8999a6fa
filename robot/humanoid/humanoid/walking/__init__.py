"""Balance: how a body with motors, and nothing else, stands and walks. It knows no ROS and no simulation."""
