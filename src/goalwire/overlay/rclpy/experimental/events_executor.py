"""rclpy.experimental.events_executor: an executor that is driven by events, not by wait sets."""

from __future__ import annotations

from rclpy._reexports import reexport
from rclpy.executors import SingleThreadedExecutor

__all__ = ['EventsExecutor']


class EventsExecutor(SingleThreadedExecutor):
    """Goalwire's single-threaded executor under the name of rclpy's event-driven executor.

    All executors of goalwire are driven by events.
    """


reexport(__name__)
