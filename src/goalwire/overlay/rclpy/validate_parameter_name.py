"""rclpy.validate_parameter_name: checks names of parameters."""

from rclpy._reexports import reexport
from rclpy.exceptions import InvalidParameterException


def validate_parameter_name(name: str) -> bool:
    """Return True for a valid name; raises InvalidParameterException for an empty name."""
    if not name:
        raise InvalidParameterException(name)
    return True


reexport(__name__)
