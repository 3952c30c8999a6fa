"""rclpy.experimental.events_executor: an executor that is driven by events, not by wait sets."""

from __future__ import annotations

from rclpy._reexports import reexport
from rclpy.executors import SingleThreadedExecutor

__all__ = ['EventsExecutor']


class EventsExecutor(SingleThreadedExecutor):
    """The single-threaded executor under rclpy's name for one driven by events; goalwire's all are."""


reexport(__name__)
