"""launch_ros.events.matchers: offers the names of ROS 2's module of this name."""

from goalwire.launching.ros.lifecycle import (
    matches_node_name,
)

__all__ = [
    'matches_node_name',
]
