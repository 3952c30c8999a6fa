"""rclpy.timer: periodic callbacks, and a rate to sleep by."""

from goalwire.execution.timer import Rate, Timer, TimerInfo
from rclpy._reexports import reexport

__all__ = ['Rate', 'Timer', 'TimerInfo']

reexport(__name__)
