"""rclpy.task: results that come later."""

from goalwire.execution.future import Future
from goalwire.execution.task import Task
from rclpy._borrowed import borrow

__all__ = ['Future', 'Task']

borrow(__name__)
