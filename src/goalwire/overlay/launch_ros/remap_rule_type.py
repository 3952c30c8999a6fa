"""launch_ros.remap_rule_type: the names of ROS 2's module."""

from goalwire.launching.ros.remappings import (
    RemapRule,
    SomeRemapRules,
)

__all__ = [
    'RemapRule',
    'SomeRemapRules',
]
