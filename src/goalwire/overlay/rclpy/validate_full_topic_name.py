"""rclpy.validate_full_topic_name: checks fully-qualified topic and service names."""

from goalwire.entities.names import check_is_name, rclpy_exceptions
from goalwire.rules import names
from rclpy._reexports import reexport


def validate_full_topic_name(name: str, *, is_service: bool = False) -> bool:
    """Return True for a valid name; raises InvalidTopicNameException or InvalidServiceNameException."""
    check_is_name(name)
    with rclpy_exceptions():
        names.validate_full_topic_name(name, is_service=is_service)
    return True


reexport(__name__)
