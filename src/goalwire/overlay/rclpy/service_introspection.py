"""rclpy.service_introspection: how much of service calls is published."""

from goalwire.entities.service_introspection import ServiceIntrospectionState
from rclpy._reexports import reexport

__all__ = ['ServiceIntrospectionState']

reexport(__name__)
