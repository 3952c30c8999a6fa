"""rclpy.service_introspection: the states that set which parts of service calls are published."""

from goalwire.entities.service_introspection import ServiceIntrospectionState
from rclpy._reexports import reexport

__all__ = ['ServiceIntrospectionState']

reexport(__name__)
