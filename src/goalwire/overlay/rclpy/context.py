"""rclpy.context: the class Context, the state of a program between init() and shutdown()."""

from goalwire.entities.context import Context
from rclpy._reexports import reexport

__all__ = ['Context']

reexport(__name__)
