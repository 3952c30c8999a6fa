"""sensor_msgs_py: its module point_cloud2 converts point clouds to numpy arrays and back."""
