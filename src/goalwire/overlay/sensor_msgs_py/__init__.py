"""sensor_msgs_py: converts point clouds to numpy arrays, in sensor_msgs_py.point_cloud2."""
