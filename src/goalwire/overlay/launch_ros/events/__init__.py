"""launch_ros.events: offers the names of ROS 2's module of this name."""

from goalwire.launching.ros.lifecycle import matches_node_name
from launch_ros.events import lifecycle, matchers

__all__ = ['lifecycle', 'matchers', 'matches_node_name']
