"""Converts between seconds and ROS's Time and Duration."""

from __future__ import annotations

from builtin_interfaces.msg import Duration as DurationMsg
from builtin_interfaces.msg import Time as TimeMsg
from rclpy.node import Node

NANOSECONDS = 1_000_000_000
LAST = 2**31 * NANOSECONDS - 1  # the last time that a ROS message can hold, in January 2038


def now(node: Node) -> float:
    """Return the time of the node's clock in seconds."""
    return node.get_clock().now().nanoseconds / NANOSECONDS


def stamp(node: Node) -> TimeMsg:
    """Return the time of the node's clock as a Time message."""
    return time_msg(node.get_clock().now().nanoseconds)


def time_msg(nanoseconds: int) -> TimeMsg:
    """Return a time (ns since 1970) as a message; a time after LAST becomes LAST."""
    sec, nanosec = divmod(min(nanoseconds, LAST), NANOSECONDS)
    return TimeMsg(sec=sec, nanosec=nanosec)


def seconds(moment: TimeMsg | DurationMsg) -> float:
    return moment.sec + moment.nanosec / NANOSECONDS


def duration_msg(length: float) -> DurationMsg:
    """Return `length` seconds as a message; more than 68 years, a message's maximum, become 68 years."""
    sec, nanosec = divmod(round(min(length * NANOSECONDS, LAST)), NANOSECONDS)
    return DurationMsg(sec=sec, nanosec=nanosec)
