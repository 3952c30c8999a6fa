"""rclpy.validate_namespace: checks namespaces of nodes."""

from goalwire.entities.names import check_is_name, rclpy_exceptions
from goalwire.rules import names
from rclpy._reexports import reexport


def validate_namespace(namespace: str) -> bool:
    """Return True if valid; raises InvalidNamespaceException, which shows the wrong character."""
    check_is_name(namespace)
    with rclpy_exceptions():
        names.validate_namespace(namespace)
    return True


reexport(__name__)
