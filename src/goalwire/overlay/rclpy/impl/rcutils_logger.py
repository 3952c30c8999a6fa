"""rclpy.impl.rcutils_logger: the logger, and the filters of its calls (once, skip_first, …)."""

from goalwire.logging.filters import (
    LoggingFilter,
    Once,
    SkipFirst,
    Throttle,
    get_filters_from_kwargs,
    supported_filters,
)
from goalwire.logging.logger import RcutilsLogger
from goalwire.logging.record import CallerId, LoggingSeverity
from rclpy._reexports import reexport

__all__ = [
    'CallerId',
    'LoggingFilter',
    'LoggingSeverity',
    'Once',
    'RcutilsLogger',
    'SkipFirst',
    'Throttle',
    'get_filters_from_kwargs',
    'supported_filters',
]

reexport(__name__)
