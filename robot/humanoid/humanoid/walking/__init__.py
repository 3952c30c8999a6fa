"""Balance: how a body stands and walks by its motors. It knows neither ROS nor a simulation."""
