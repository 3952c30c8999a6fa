"""rclpy.guard_condition: a callback that the program itself triggers."""

from goalwire.execution.guard_condition import GuardCondition

__all__ = ['GuardCondition']
