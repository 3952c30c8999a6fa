"""tf2_ros.Buffer: stores transforms and waits for them."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from functools import partial
from threading import Lock
from typing import TYPE_CHECKING, Any

from geometry_msgs.msg import TransformStamped
from rclpy.clock import Clock, JumpThreshold, TimeJump
from rclpy.context import Context
from rclpy.duration import Duration
from rclpy.logging import get_logger
from rclpy.node import Node
from rclpy.task import Future
from rclpy.utilities import get_default_context
from tf2_msgs.srv import FrameGraph
from tf2_py import BufferCore, TransformException
from tf2_py.buffer_core import Instant

from goalwire.execution.event_queue import EventQueue
from goalwire.execution.time.clock import block_on_clock
from goalwire.execution.wait_sets.waitable import unwatch, watch
from goalwire.weak_members import WeakMembers
from tf2_ros.buffer_interface import NO_TIME, BufferInterface

if TYPE_CHECKING:
    from goalwire.execution.shutdown_signal import ShutdownSignal

__all__ = ['Buffer']

Lookup = Callable[[], TransformStamped]
Check = Callable[[], tuple[bool, str]]


class Buffer(BufferCore, BufferInterface):
    """Keeps transforms for `cache_time` (default: 10 s); with a node, offers the service tf2_frames.

    If the node's clock jumps back in time, the buffer is cleared.
    """

    def __init__(self, cache_time: Duration | None = None, node: Node | None = None) -> None:
        BufferCore.__init__(self, cache_time)
        BufferInterface.__init__(self)
        self._context: Context = get_default_context() if node is None else node.context
        self._waiting: dict[Future[TransformStamped], Lookup] = {}
        self._event_queues: WeakMembers[EventQueue[Any]] = WeakMembers()
        self._waiting_lock = Lock()
        self.clock = Clock() if node is None else node.get_clock()
        if node is not None:
            self.srv: Any = node.create_service(FrameGraph, 'tf2_frames', self._get_frames)
        self.jump_handle = self.clock.create_jump_callback(
            JumpThreshold(min_forward=None, min_backward=Duration(seconds=-1), on_clock_change=True),
            post_callback=self.time_jump_callback,
        )

    def time_jump_callback(self, time_jump: TimeJump) -> None:
        """Forget all transforms, since their times may be in the future now."""
        get_logger('tf2_buffer').warning('Detected jump back in time. Clearing tf buffer.')
        self.clear()

    def set_transform(self, transform: TransformStamped, authority: str) -> None:
        """Store a transform for the time of its stamp, and complete the lookups that wait for it."""
        super().set_transform(transform, authority)
        self._settle_waiting()

    def set_transform_static(self, transform: TransformStamped, authority: str) -> None:
        """Store a transform for all times, and complete the lookups that wait for it."""
        super().set_transform_static(transform, authority)
        self._settle_waiting()

    def lookup_transform(
        self, target_frame: str, source_frame: str, time: Instant, timeout: Duration = NO_TIME
    ) -> TransformStamped:
        """Return the transform from source to target at a time; 0 means the latest time.

        Waits for the transform up to `timeout`, then raises as lookup_transform_core does. A callback may
        wait, too: the waiting thread itself then handles the messages of the buffer's listeners.
        """
        lookup = partial(self.lookup_transform_core, target_frame, source_frame, time)
        self._wait(lookup, timeout)
        return lookup()

    def lookup_transform_full(
        self,
        target_frame: str,
        target_time: Instant,
        source_frame: str,
        source_time: Instant,
        fixed_frame: str,
        timeout: Duration = NO_TIME,
    ) -> TransformStamped:
        """Return the transform from source at one time to target at another; waits as lookup_transform."""
        lookup = partial(
            self.lookup_transform_full_core, target_frame, target_time, source_frame, source_time, fixed_frame
        )
        self._wait(lookup, timeout)
        return lookup()

    async def lookup_transform_async(
        self, target_frame: str, source_frame: str, time: Instant
    ) -> TransformStamped:
        """Wait for the transform without a limit, and return it."""
        await self.wait_for_transform_async(target_frame, source_frame, time)
        return self.lookup_transform_core(target_frame, source_frame, time)

    async def lookup_transform_full_async(
        self,
        target_frame: str,
        target_time: Instant,
        source_frame: str,
        source_time: Instant,
        fixed_frame: str,
    ) -> TransformStamped:
        """Wait for the transform without a limit, and return it."""
        times_and_frames = target_frame, target_time, source_frame, source_time, fixed_frame
        await self.wait_for_transform_full_async(*times_and_frames)
        return self.lookup_transform_full_core(*times_and_frames)

    def can_transform(
        self,
        target_frame: str,
        source_frame: str,
        time: Instant,
        timeout: Duration = NO_TIME,
        return_debug_tuple: bool = False,
    ) -> bool | tuple[bool, str]:
        """Return whether the transform is available within `timeout`; with `return_debug_tuple` also the
        reason.
        """
        self._wait(partial(self.lookup_transform_core, target_frame, source_frame, time), timeout)
        answer = self.can_transform_core(target_frame, source_frame, time)
        return answer if return_debug_tuple else answer[0]

    def can_transform_full(
        self,
        target_frame: str,
        target_time: Instant,
        source_frame: str,
        source_time: Instant,
        fixed_frame: str,
        timeout: Duration = NO_TIME,
        return_debug_tuple: bool = False,
    ) -> bool | tuple[bool, str]:
        """Do as can_transform, for a source at one time and a target at another."""
        times_and_frames = target_frame, target_time, source_frame, source_time, fixed_frame
        self._wait(partial(self.lookup_transform_full_core, *times_and_frames), timeout)
        answer = self.can_transform_full_core(*times_and_frames)
        return answer if return_debug_tuple else answer[0]

    def wait_for_transform_async(
        self, target_frame: str, source_frame: str, time: Instant
    ) -> Future[TransformStamped]:
        """Return a future that is done as soon as the transform is available, and gives the transform."""
        return self._future(partial(self.lookup_transform_core, target_frame, source_frame, time))

    def wait_for_transform_full_async(
        self,
        target_frame: str,
        target_time: Instant,
        source_frame: str,
        source_time: Instant,
        fixed_frame: str,
    ) -> Future[TransformStamped]:
        """Return a future that is done as soon as the transform is available, and gives the transform."""
        return self._future(
            partial(
                self.lookup_transform_full_core,
                target_frame,
                target_time,
                source_frame,
                source_time,
                fixed_frame,
            )
        )

    def hear(self, event_queue: EventQueue[Any]) -> None:
        """Register a listener's event queue, so that a waiting lookup also handles the queue's messages."""
        with self._waiting_lock:
            self._event_queues.add(event_queue)

    def _wait(self, lookup: Lookup, timeout: Duration) -> None:
        """Block until `lookup` succeeds, `timeout` has passed on the buffer's clock, or the context ends."""
        if timeout.nanoseconds <= 0:
            return
        future = self._future(lookup)
        until_ns = self.clock.now_ns() + timeout.nanoseconds
        with self._waiting_lock:
            event_queues = self._event_queues.alive()
        try:
            _wait_hearing(future, event_queues, self.clock, until_ns, self._context.shutdown_signal)
        finally:
            future.cancel()

    def _future(self, lookup: Lookup) -> Future[TransformStamped]:
        """Return a future of the transform that is done as soon as `lookup` succeeds."""
        future: Future[TransformStamped] = Future()
        with self._waiting_lock:
            self._waiting[future] = lookup
        self._settle(future, lookup)
        future.add_done_callback(self._forget)
        return future

    def _settle_waiting(self) -> None:
        with self._waiting_lock:
            waiting = list(self._waiting.items())
        for future, lookup in waiting:
            self._settle(future, lookup)

    def _settle(self, future: Future[TransformStamped], lookup: Lookup) -> None:
        try:
            found = lookup()
        except TransformException:
            return  # the transform has not arrived yet
        with self._waiting_lock:
            first = self._waiting.pop(future, None) is not None
        if first:
            future.set_result(found)

    def _forget(self, future: Future[TransformStamped]) -> None:
        with self._waiting_lock:
            self._waiting.pop(future, None)

    def _get_frames(self, request: FrameGraph.Request, response: FrameGraph.Response) -> FrameGraph.Response:
        response.frame_yaml = self.all_frames_as_yaml()
        return response


def _wait_hearing(
    future: Future[Any],
    event_queues: Iterable[EventQueue[Any]],
    clock: Clock,
    until_ns: int,
    shutdown_signal: ShutdownSignal,
) -> None:
    """Handle the listeners' messages until `future` is done, `clock` shows `until_ns`, or shutdown.

    A callback that waits in a single-threaded executor blocks the only thread that would handle the messages.
    So the waiting thread handles them itself. Raises the errors of the subscriptions' callbacks.
    """
    heard = list(event_queues)
    arrival: Future[None] = Future()

    def tell() -> None:  # may be called on any thread
        arrival.set_result(None)

    for event_queue in heard:
        watch(event_queue, tell)
    future.add_waker(tell)
    try:
        while True:
            arrival = Future()  # made before the queues are read, so that no later message is missed
            for event_queue in heard:
                while future.pending() and (event := event_queue.take()) is not None:
                    event_queue.handle(event)
            if not future.pending() or not block_on_clock(arrival, clock, until_ns, shutdown_signal):
                return
    finally:
        future.remove_waker(tell)
        for event_queue in heard:
            unwatch(event_queue, tell)
