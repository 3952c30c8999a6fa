"""Seconds and ROS time."""

from __future__ import annotations

from builtin_interfaces.msg import Duration as DurationMsg
from builtin_interfaces.msg import Time as TimeMsg
from rclpy.node import Node

NANOSECONDS = 1_000_000_000
LAST = 2**31 * NANOSECONDS - 1  # the last moment that ROS messages can name, in January 2038


def now(node: Node) -> float:
    """The node's clock in seconds."""
    return node.get_clock().now().nanoseconds / NANOSECONDS


def stamp(node: Node) -> TimeMsg:
    """The node's clock as a message."""
    return time_msg(node.get_clock().now().nanoseconds)


def time_msg(nanoseconds: int) -> TimeMsg:
    """Since 1970; a later moment than messages can name becomes the last one of these."""
    sec, nanosec = divmod(min(nanoseconds, LAST), NANOSECONDS)
    return TimeMsg(sec=sec, nanosec=nanosec)


def seconds(moment: TimeMsg | DurationMsg) -> float:
    return moment.sec + moment.nanosec / NANOSECONDS


def duration_msg(length: float) -> DurationMsg:
    """`length` in seconds; one longer than messages can name (68 years) becomes the longest of these."""
    sec, nanosec = divmod(round(min(length * NANOSECONDS, LAST)), NANOSECONDS)
    return DurationMsg(sec=sec, nanosec=nanosec)
