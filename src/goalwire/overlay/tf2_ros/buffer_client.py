"""tf2_ros.BufferClient: asks a buffer in another process (a tf2_ros buffer_server)."""

from __future__ import annotations

from typing import Any

from builtin_interfaces.msg import Duration as Span
from builtin_interfaces.msg import Time as TimeMessage
from geometry_msgs.msg import TransformStamped
from rclpy.action import ActionClient
from rclpy.duration import Duration
from rclpy.node import Node
from rclpy.task import Future
from rclpy.time import Time
from tf2_msgs.action import LookupTransform
from tf2_msgs.msg import TF2Error
from tf2_py import (
    ConnectivityException,
    ExtrapolationException,
    InvalidArgumentException,
    LookupException,
    TimeoutException,
    TransformException,
)
from tf2_py.buffer_core import Instant

from goalwire.execution.future import block_on
from goalwire.execution.time.steady_clock import deadline_after
from tf2_ros.buffer_interface import NO_TIME, BufferInterface

__all__ = ['BufferClient']

DEFAULT_PADDING = Duration(seconds=2)

_EXCEPTIONS: dict[int, type[TransformException]] = {
    TF2Error.LOOKUP_ERROR: LookupException,
    TF2Error.CONNECTIVITY_ERROR: ConnectivityException,
    TF2Error.EXTRAPOLATION_ERROR: ExtrapolationException,
    TF2Error.INVALID_ARGUMENT_ERROR: InvalidArgumentException,
    TF2Error.TIMEOUT_ERROR: TimeoutException,
}


class BufferClient(BufferInterface):
    """Looks up transforms by an action, whose name is `ns`. The node need not spin.

    The server's answer may take the lookup's timeout plus `timeout_padding`. The client does not poll, so
    `check_frequency` has no effect.
    """

    def __init__(
        self,
        node: Node,
        ns: str,
        check_frequency: float = 10.0,
        timeout_padding: Duration = DEFAULT_PADDING,
    ) -> None:
        super().__init__()
        self.node = node
        self.check_frequency = check_frequency
        self.timeout_padding = timeout_padding
        self.action_client = ActionClient(node, LookupTransform, ns)

    def lookup_transform(
        self, target_frame: str, source_frame: str, time: Instant, timeout: Duration = NO_TIME
    ) -> TransformStamped:
        """Return the transform from source to target at a time; 0 means the latest time.

        Raises TimeoutException if the server is missing or late, and the exception that the server reports.
        """
        goal = LookupTransform.Goal(
            target_frame=target_frame,
            source_frame=source_frame,
            source_time=_to_message(time),
            timeout=_to_span(timeout),
        )
        return self._process(goal, timeout)

    def lookup_transform_full(
        self,
        target_frame: str,
        target_time: Instant,
        source_frame: str,
        source_time: Instant,
        fixed_frame: str,
        timeout: Duration = NO_TIME,
    ) -> TransformStamped:
        """Return the transform from source at one time to target at another; raises as lookup_transform."""
        goal = LookupTransform.Goal(
            target_frame=target_frame,
            source_frame=source_frame,
            source_time=_to_message(source_time),
            timeout=_to_span(timeout),
            target_time=_to_message(target_time),
            fixed_frame=fixed_frame,
            advanced=True,
        )
        return self._process(goal, timeout)

    def can_transform(
        self, target_frame: str, source_frame: str, time: Instant, timeout: Duration = NO_TIME
    ) -> bool:
        """Return whether lookup_transform succeeds."""
        try:
            self.lookup_transform(target_frame, source_frame, time, timeout)
        except TransformException:
            return False
        return True

    def can_transform_full(
        self,
        target_frame: str,
        target_time: Instant,
        source_frame: str,
        source_time: Instant,
        fixed_frame: str,
        timeout: Duration = NO_TIME,
    ) -> bool:
        """Return whether lookup_transform_full succeeds."""
        try:
            self.lookup_transform_full(
                target_frame, target_time, source_frame, source_time, fixed_frame, timeout
            )
        except TransformException:
            return False
        return True

    def destroy(self) -> None:
        """Destroy the action client. Idempotent."""
        self.action_client.destroy()

    def _process(self, goal: LookupTransform.Goal, timeout: Duration) -> TransformStamped:
        if not self.action_client.server_is_ready():
            raise TimeoutException('The BufferServer is not ready.')
        clock = self.node.context.shutdown_signal.clock
        deadline = deadline_after(clock, (timeout.nanoseconds + self.timeout_padding.nanoseconds) / 1e9)
        handle = self._settle(self.action_client.send_goal_async(goal), deadline)
        if not handle.accepted:
            raise TimeoutException('The BufferServer refused the LookupTransform goal.')
        result = self._settle(handle.get_result_async(), deadline).result
        if result.error.error == TF2Error.NO_ERROR:
            transform: TransformStamped = result.transform
            return transform
        raise _EXCEPTIONS.get(result.error.error, TransformException)(result.error.error_string)

    def _settle(self, future: Future[Any], deadline: int | None) -> Any:
        if not block_on(future, deadline, self.node.context.shutdown_signal):
            raise TimeoutException(
                'The LookupTransform goal sent to the BufferServer did not come back in the specified time: '
                'the server hangs, or was shut down.'
            )
        return future.result()


def _to_span(duration: Duration) -> Span:
    sec, nanosec = divmod(duration.nanoseconds, 1_000_000_000)
    return Span(sec=sec, nanosec=nanosec)


def _to_message(time: Instant) -> TimeMessage:
    if isinstance(time, Time):
        sec, nanosec = time.seconds_nanoseconds()
        return TimeMessage(sec=sec, nanosec=nanosec)
    return TimeMessage(sec=time.sec, nanosec=time.nanosec)
