"""rclpy.validate_namespace: checks namespaces of nodes."""

from goalwire.entities.names import check_is_name, rclpy_exceptions
from goalwire.rules import names
from rclpy._reexports import reexport


def validate_namespace(namespace: str) -> bool:
    """Return True; raises InvalidNamespaceException, which points at the wrong character."""
    check_is_name(namespace)
    with rclpy_exceptions():
        names.validate_namespace(namespace)
    return True


reexport(__name__)
