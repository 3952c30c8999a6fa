"""goalwire: ROS 2's topics, services and actions for Python, from one pip install."""

__version__ = '0.1.0'
