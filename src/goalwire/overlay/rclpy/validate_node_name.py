"""rclpy.validate_node_name: checks names of nodes."""

from goalwire.entities.names import check_is_name, rclpy_exceptions
from goalwire.rules import names
from rclpy._reexports import reexport


def validate_node_name(node_name: str) -> bool:
    """Return True for a valid name; raises InvalidNodeNameException, which shows the wrong character."""
    check_is_name(node_name)
    with rclpy_exceptions():
        names.validate_node_name(node_name)
    return True


reexport(__name__)
