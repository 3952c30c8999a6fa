"""rclpy.guard_condition: a callback that the program itself triggers."""

from goalwire.execution.event_queue import GuardCondition
from rclpy._borrowed import borrow

__all__ = ['GuardCondition']

borrow(__name__)
