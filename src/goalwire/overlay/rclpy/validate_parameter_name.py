"""rclpy.validate_parameter_name: a parameter needs a name."""

from rclpy._borrowed import borrow
from rclpy.exceptions import InvalidParameterException


def validate_parameter_name(name: str) -> bool:
    """Return True; raises InvalidParameterException for an empty name."""
    if not name:
        raise InvalidParameterException(name)
    return True


borrow(__name__)
