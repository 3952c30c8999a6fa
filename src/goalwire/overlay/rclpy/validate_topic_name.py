"""rclpy.validate_topic_name: checks topic and service names as users write them."""

from goalwire.entities.names import check_is_name, rclpy_exceptions
from goalwire.rules import names
from rclpy._reexports import reexport

TOPIC_SEPARATOR_STRING = '/'


def validate_topic_name(name: str, *, is_service: bool = False) -> bool:
    """Return True for a valid name; raises InvalidTopicNameException or InvalidServiceNameException."""
    check_is_name(name, 'failed to validate name: topic_name argument is null')
    with rclpy_exceptions():
        names.validate_topic_name(name, is_service=is_service)
    return True


reexport(__name__)
