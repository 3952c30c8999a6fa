"""rclpy.type_support: tells message classes, service classes and others apart."""

from goalwire.entities.type_support import (
    check_for_type_support,
    check_is_valid_msg_type,
    check_is_valid_srv_type,
)

__all__ = ['check_for_type_support', 'check_is_valid_msg_type', 'check_is_valid_srv_type']
