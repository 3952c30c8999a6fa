"""launch_ros.remap_rule_type."""

from goalwire.launching.ros.remappings import (
    RemapRule,
    SomeRemapRules,
)

__all__ = [
    'RemapRule',
    'SomeRemapRules',
]
