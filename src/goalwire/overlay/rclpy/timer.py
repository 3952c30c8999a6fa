"""rclpy.timer: callbacks at a rhythm, and sleeping at one."""

from goalwire.execution.timer import Rate, Timer, TimerInfo

__all__ = ['Rate', 'Timer', 'TimerInfo']
