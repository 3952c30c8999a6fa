"""rclpy.context: what lives from init() to shutdown()."""

from goalwire.entities.context import Context
from rclpy._reexports import reexport

__all__ = ['Context']

reexport(__name__)
