"""rclpy.timer: timers, which call back periodically, and Rate, which keeps a loop at a frequency."""

from goalwire.execution.time.timer import Rate, Timer, TimerInfo
from rclpy._reexports import reexport

__all__ = ['Rate', 'Timer', 'TimerInfo']

reexport(__name__)
