"""launch_ros.events.matchers: the names of ROS 2's module."""

from goalwire.launching.ros.lifecycle import (
    matches_node_name,
)

__all__ = [
    'matches_node_name',
]
