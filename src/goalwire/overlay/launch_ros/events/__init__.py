"""launch_ros.events."""

from goalwire.launching.ros.lifecycle import (
    matches_node_name,
)

__all__ = [
    'matches_node_name',
]
