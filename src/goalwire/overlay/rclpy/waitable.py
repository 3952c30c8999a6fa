"""rclpy.waitable: a source of callbacks of one's own."""

from goalwire.execution.waitable import NumberOfEntities, Waitable

__all__ = ['NumberOfEntities', 'Waitable']
