"""rclpy.waitable: the base class for sources of callbacks that a program defines itself."""

from goalwire.execution.waitable import NumberOfEntities, Waitable

__all__ = ['NumberOfEntities', 'Waitable']
