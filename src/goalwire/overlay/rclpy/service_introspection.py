"""rclpy.service_introspection: what is published of service calls."""

from goalwire.entities.service_introspection import ServiceIntrospectionState
from rclpy._borrowed import borrow

__all__ = ['ServiceIntrospectionState']

borrow(__name__)
