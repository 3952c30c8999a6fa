"""GuardCondition: a callback that the program triggers itself (rclpy.guard_condition)."""

from __future__ import annotations

from typing import TYPE_CHECKING

from goalwire.errors import InvalidHandle
from goalwire.execution.callback_source import CallbackSource
from goalwire.execution.handle import handle_of
from goalwire.execution.node_work_queue import NodeWorkQueue

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence

    from goalwire.execution.callback_groups import CallbackGroup
    from goalwire.execution.shutdown_signal import ContextLike


class GuardCondition(CallbackSource):
    """Triggers that come before the callback has run count as one."""

    __slots__ = ('__dict__', '_destroyed', '_posted', 'callback', 'events', 'watchers')

    counts_up = True

    def __init__(
        self,
        callback: Callable[[], object] | None,
        callback_group: CallbackGroup | None,
        context: ContextLike | None = None,  # noqa: ARG002
        *,
        work_queue: NodeWorkQueue | None = None,
    ) -> None:
        super().__init__(NodeWorkQueue() if work_queue is None else work_queue, callback_group)
        self.callback = callback
        self._posted = self._destroyed = False
        self.events = 0
        """How often it was triggered; those that come at once may count as one. See wait_set.Waited."""
        self.watchers: Sequence[Callable[[], None]] = ()

    @property
    def callback_group(self) -> CallbackGroup | None:
        """The group that it was made with."""
        return self.group

    @property
    def handle(self) -> GuardCondition:
        """What programs hold it by. Raises InvalidHandle once destroyed."""
        if self._destroyed:
            raise InvalidHandle
        return handle_of(self)

    def trigger(self) -> None:
        """Have the callback called soon. Any thread, signal handlers too. InvalidHandle once destroyed."""
        if self._destroyed:
            raise InvalidHandle
        self.events += 1
        if not self._posted:
            self._posted = True
            self.work_queue.post(self)
        for wake in self.watchers:
            wake()

    def destroy(self) -> None:
        """End it. Idempotent."""
        self._destroyed = True

    def run(self) -> object:
        self._posted = False
        if self._destroyed or self.callback is None:
            return None
        return self.callback()
