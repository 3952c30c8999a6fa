"""rclpy.service_introspection: the parts of service calls that are published."""

from goalwire.entities.service_introspection import ServiceIntrospectionState
from rclpy._reexports import reexport

__all__ = ['ServiceIntrospectionState']

reexport(__name__)
