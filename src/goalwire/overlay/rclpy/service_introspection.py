"""rclpy.service_introspection: what is published of service calls."""

from goalwire.entities.service_introspection import ServiceIntrospectionState
from rclpy._reexports import reexport

__all__ = ['ServiceIntrospectionState']

reexport(__name__)
