"""The time of a message: its header's stamp, or the time of its arrival."""

from __future__ import annotations

from typing import Any

from rclpy.clock import ROSClock
from rclpy.logging import get_logger
from rclpy.time import Time

__all__ = ['stamp_of', 'stamp_or_arrival']


def stamp_of(msg: Any) -> Time:
    """Return the stamp of a message's header; raises AttributeError if the message has no such field."""
    stamp = msg.header.stamp
    return stamp if hasattr(stamp, 'nanoseconds') else Time.from_msg(stamp)


def stamp_or_arrival(msg: Any, *, allow_headerless: bool, logger_name: str) -> Time | None:
    """Return a message's stamp.

    Without a header return the current time if `allow_headerless`; otherwise warn and return None.
    """
    if hasattr(msg, 'header') and hasattr(msg.header, 'stamp'):
        return stamp_of(msg)
    if allow_headerless:
        return ROSClock().now()
    get_logger(logger_name).warning(
        f'a {type(msg).__name__} is dropped: it has no header.stamp '
        '(allow_headerless=True would take the time of its arrival)'
    )
    return None
