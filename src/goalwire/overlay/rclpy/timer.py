"""rclpy.timer: callbacks at a rhythm, and sleeping at one."""

from goalwire.execution.timer import Rate, Timer, TimerInfo
from rclpy._borrowed import borrow

__all__ = ['Rate', 'Timer', 'TimerInfo']

borrow(__name__)
