"""rclpy.guard_condition: guard conditions, whose callbacks the program itself triggers."""

from goalwire.execution.event_queue import GuardCondition
from rclpy._reexports import reexport

__all__ = ['GuardCondition']

reexport(__name__)
