"""rclpy.duration: the class Duration, a span of time."""

from goalwire.rules.time import Duration, DurationType, Infinite
from rclpy._reexports import reexport
from rclpy.constants import S_TO_NS

__all__ = ['S_TO_NS', 'Duration', 'DurationType', 'Infinite']

reexport(__name__)
