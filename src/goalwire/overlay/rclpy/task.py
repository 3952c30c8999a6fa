"""rclpy.task: futures and tasks, whose results come later."""

from goalwire.execution.future import Future
from goalwire.execution.task import Task
from rclpy._reexports import reexport

__all__ = ['Future', 'Task']

reexport(__name__)
