"""launch_ros.remap_rule_type."""

from goalwire.launching.ros.node import (
    Remappings as SomeRemapRules,
)

__all__ = [
    'SomeRemapRules',
]
