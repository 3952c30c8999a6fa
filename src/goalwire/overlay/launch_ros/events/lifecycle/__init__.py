"""launch_ros.events.lifecycle: the events for state transitions of managed nodes."""

from goalwire.launching.aliases import add_modules
from goalwire.launching.ros.lifecycle import (
    ChangeState,
    StateTransition,
    matches_node_name,
)

__all__ = [
    'ChangeState',
    'StateTransition',
    'matches_node_name',
]

add_modules(__name__, {'matches_node_name': 'lifecycle_node_matchers'})
