"""Seconds and ROS time."""

from __future__ import annotations

from builtin_interfaces.msg import Duration as DurationMsg
from builtin_interfaces.msg import Time as TimeMsg
from rclpy.node import Node

NANOSECONDS = 1_000_000_000


def now(node: Node) -> float:
    """The node's clock in seconds."""
    return node.get_clock().now().nanoseconds / NANOSECONDS


def stamp(node: Node) -> TimeMsg:
    """The node's clock as a message."""
    sec, nanosec = divmod(node.get_clock().now().nanoseconds, NANOSECONDS)
    return TimeMsg(sec=sec, nanosec=nanosec)


def seconds(moment: TimeMsg | DurationMsg) -> float:
    return moment.sec + moment.nanosec / NANOSECONDS


def duration_msg(length: float) -> DurationMsg:
    sec, nanosec = divmod(round(length * NANOSECONDS), NANOSECONDS)
    return DurationMsg(sec=sec, nanosec=nanosec)
