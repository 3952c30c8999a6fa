"""launch_ros.actions.load_composable_nodes: offers the names of ROS 2's module of this name."""

from goalwire.launching.ros.composition import (
    LoadComposableNodes,
)
from goalwire.launching.ros.load_requests import (
    get_composable_node_load_request,
)

__all__ = [
    'LoadComposableNodes',
    'get_composable_node_load_request',
]
