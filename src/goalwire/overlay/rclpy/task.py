"""rclpy.task: results that come later."""

from goalwire.execution.future import Future
from goalwire.execution.task import Task

__all__ = ['Future', 'Task']
