"""rclpy.service_introspection: what is published of service calls."""

from goalwire.entities.service_introspection import ServiceIntrospectionState

__all__ = ['ServiceIntrospectionState']
