"""Why a spin or a wait ended (rclpy.executors' exceptions)."""

from __future__ import annotations

from goalwire.errors import ClosedError, GoalwireError


class TimeoutException(GoalwireError):
    """The time was up."""


class ShutdownException(ClosedError):
    """The executor was shut down."""


class ExternalShutdownException(ClosedError):
    """The context was shut down: by rclpy.shutdown(), or by a signal."""


class ConditionReachedException(GoalwireError):
    """The condition that was waited for is true."""
