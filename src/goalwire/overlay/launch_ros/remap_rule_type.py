"""launch_ros.remap_rule_type: offers the names of ROS 2's module of this name."""

from goalwire.launching.ros.remappings import (
    RemapRule,
    SomeRemapRules,
)

__all__ = [
    'RemapRule',
    'SomeRemapRules',
]
