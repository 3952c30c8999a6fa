"""rclpy.timer: callbacks at a rhythm, and sleeping at one."""

from goalwire.execution.timer import Rate, Timer, TimerInfo
from rclpy._reexports import reexport

__all__ = ['Rate', 'Timer', 'TimerInfo']

reexport(__name__)
