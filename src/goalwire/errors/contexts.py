"""Errors of contexts and executors: not opened, closed, shut down, or what rcl would refuse."""

from __future__ import annotations

from goalwire.errors.base import GoalwireError, LocalError


class ClosedError(LocalError):
    """A context, node or endpoint was used after it was closed."""


class InvalidHandle(ClosedError):
    """A destroyed entity was used (rclpy.exceptions.InvalidHandle)."""

    def __init__(self, message: str = 'cannot use Destroyable because destruction was requested') -> None:
        super().__init__(message)


class DestroyedError(InvalidHandle, RuntimeError):
    """A destroyed entity was used in a call for which rclpy raises RuntimeError."""


class ShutdownException(ClosedError):
    """The executor was shut down."""


class ExternalShutdownException(ClosedError):
    """The context was shut down: by rclpy.shutdown(), or by a signal."""


class NotInitializedException(LocalError):
    """rclpy.init() has not been called (rclpy.exceptions)."""

    def __init__(self, message: str | None = None) -> None:
        text = 'rclpy.init() has not been called'
        super().__init__(f'{text}. msg:{message}' if message else f'{text}.')
        self.add_note('call rclpy.init() before this line; after rclpy.shutdown(), call it again')


class ROSInterruptException(LocalError):
    """A sleep was ended by shutdown (rclpy.exceptions)."""

    def __init__(self) -> None:
        super().__init__('rclpy.shutdown() has been called')


class TimeSourceChangedError(LocalError):
    """A sleep was ended by a switch between system and simulated time (rclpy.exceptions)."""

    def __init__(self) -> None:
        super().__init__(
            'simulated time was switched on or off during the sleep: how long is left is unknown'
        )


class ForkedError(LocalError):
    """A context opened before fork() was used in the child process."""


class RCLError(LocalError, RuntimeError):
    """A call failed in a way in which a function of rcl, ROS 2's C library, would fail."""


class RMWError(LocalError, RuntimeError):
    """Never raised by goalwire. Programs catch it, since rclpy raises it if its middleware fails."""


class RCUtilsError(LocalError, RuntimeError):
    """Never raised by goalwire. Programs catch it, since rclpy raises it if rcutils fails."""


class ShutDownError(RCLError, ClosedError):
    """An entity was used after the end of its context."""

    def __init__(self, what: str) -> None:
        super().__init__(f'{what}: the context was shut down; do this before, or ask rclpy.ok() first')


class ShutDownBySignalError(ShutDownError, ExternalShutdownException):
    """An entity was used after a signal had ended its context.

    Programs that expect a signal catch ExternalShutdownException around their spin. So they end as usual,
    too, if a callback publishes just after the signal.
    """


class RCLInvalidROSArgsError(RCLError):
    """Arguments after --ros-args cannot be parsed."""


class UnknownROSArgsError(RCLError):
    """There are arguments after --ros-args that ROS 2 does not know."""


class UnsupportedEventTypeError(RCLError):
    """The wire in use cannot report this kind of event (rclpy.event_handler)."""

    def __init__(self, event: str, topic: str, wire: str) -> None:
        super().__init__(
            f"Failed to initialize event: {event} is not supported by {wire} (topic '{topic}'): "
            f'leave this callback out on this wire'
        )


class NodeNameNonExistentError(RCLError):
    """A query asked about a node that is not in the graph."""


class TimeoutException(GoalwireError):
    """An executor waited for the whole timeout without finding ready work."""


class ConditionReachedException(GoalwireError):
    """The condition that an executor's wait was to end with has become true."""
