"""rclpy.context: what lives from init() to shutdown()."""

from goalwire.entities.context import Context

__all__ = ['Context']
