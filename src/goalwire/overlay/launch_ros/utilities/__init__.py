"""launch_ros.utilities."""

from goalwire.launching.ros.parameters import (
    evaluate_dictionary as evaluate_parameter_dict,
)

__all__ = [
    'evaluate_parameter_dict',
]
