"""rclpy.waitable: the base class for sources of callbacks that a program defines itself."""

from goalwire.execution.wait_sets.waitable import NumberOfEntities, Waitable

__all__ = ['NumberOfEntities', 'Waitable']
