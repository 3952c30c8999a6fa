"""rclpy.waitable: the base of a program's own sources of callbacks."""

from goalwire.execution.waitable import NumberOfEntities, Waitable

__all__ = ['NumberOfEntities', 'Waitable']
