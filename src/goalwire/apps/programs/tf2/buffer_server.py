"""buffer_server: an action server that looks up transforms for its clients."""

from __future__ import annotations

import asyncio
import contextlib
from collections.abc import Sequence

from geometry_msgs.msg import TransformStamped
from rclpy.action import ActionServer, CancelResponse
from rclpy.action.server import ServerGoalHandle
from rclpy.duration import Duration
from rclpy.node import Node
from rclpy.task import Future
from rclpy.time import Time
from tf2_msgs.action import LookupTransform
from tf2_msgs.msg import TF2Error
from tf2_ros import (
    Buffer,
    ConnectivityException,
    ExtrapolationException,
    InvalidArgumentException,
    LookupException,
    TransformException,
    TransformListener,
)

from goalwire.apps.programs.running import declare_number, spin

ACTION = 'tf2_buffer_server'
ERRORS = (
    (ConnectivityException, TF2Error.CONNECTIVITY_ERROR),
    (LookupException, TF2Error.LOOKUP_ERROR),
    (ExtrapolationException, TF2Error.EXTRAPOLATION_ERROR),
    (InvalidArgumentException, TF2Error.INVALID_ARGUMENT_ERROR),
)


def _code_of(error: TransformException) -> int:
    for kind, code in ERRORS:
        if isinstance(error, kind):
            return code
    return TF2Error.TRANSFORM_ERROR


class BufferServer(Node):
    """Serves `tf2_buffer_server`: a goal ends once its transform is there, or with an error at its timeout.

    Parameters: `buffer_size` in s.
    """

    def __init__(self) -> None:
        super().__init__('tf_buffer')
        seconds = declare_number(self, 'buffer_size', 120.0)
        self._buffer = Buffer(Duration(seconds=seconds), node=self)
        self._listener = TransformListener(self._buffer, self)
        self._waits: dict[bytes, Future[TransformStamped]] = {}  # by goal id
        self._server = ActionServer(
            self, LookupTransform, ACTION, self._execute, cancel_callback=self._cancel
        )

    def _cancel(self, goal_handle: ServerGoalHandle) -> CancelResponse:
        wait = self._waits.get(bytes(goal_handle.goal_id.uuid))
        if wait is not None:
            wait.cancel()
        return CancelResponse.ACCEPT

    async def _execute(self, goal_handle: ServerGoalHandle) -> LookupTransform.Result:
        goal: LookupTransform.Goal = goal_handle.request
        result = LookupTransform.Result()
        await self._wait(goal, bytes(goal_handle.goal_id.uuid))
        if goal_handle.is_cancel_requested:
            goal_handle.canceled()
            return result
        try:
            result.transform = self._look_up(goal)
            goal_handle.succeed()
        except TransformException as error:
            result.error.error = _code_of(error)
            result.error.error_string = str(error)
            goal_handle.abort()
        return result

    async def _wait(self, goal: LookupTransform.Goal, goal_id: bytes) -> None:
        """Wait for the transform, the timeout, or a cancellation."""
        source = Time.from_msg(goal.source_time)
        if goal.advanced:
            target = Time.from_msg(goal.target_time)
            wait = self._buffer.wait_for_transform_full_async(
                goal.target_frame, target, goal.source_frame, source, goal.fixed_frame
            )
        else:
            wait = self._buffer.wait_for_transform_async(goal.target_frame, goal.source_frame, source)
        self._waits[goal_id] = wait
        try:
            # The next look-up raises the right error.
            with contextlib.suppress(TimeoutError, asyncio.CancelledError, TransformException):
                async with asyncio.timeout(Duration.from_msg(goal.timeout).nanoseconds / 1e9):
                    await wait
        finally:
            del self._waits[goal_id]
            wait.cancel()

    def _look_up(self, goal: LookupTransform.Goal) -> TransformStamped:
        source = Time.from_msg(goal.source_time)
        if goal.advanced:
            return self._buffer.lookup_transform_full(
                goal.target_frame,
                Time.from_msg(goal.target_time),
                goal.source_frame,
                source,
                goal.fixed_frame,
            )
        return self._buffer.lookup_transform(goal.target_frame, goal.source_frame, source)


def main(args: Sequence[str] | None = None) -> int:
    """Run buffer_server."""
    return spin(BufferServer, args)
