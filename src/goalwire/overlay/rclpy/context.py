"""rclpy.context: what lives from init() to shutdown()."""

from goalwire.entities.context import Context
from rclpy._borrowed import borrow

__all__ = ['Context']

borrow(__name__)
