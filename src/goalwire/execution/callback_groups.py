"""Callback groups, which decide which callbacks may run at the same time (rclpy.callback_groups)."""

from __future__ import annotations

from _thread import allocate_lock
from collections import deque
from typing import TYPE_CHECKING

from goalwire.concurrency.snapshots import copy_of
from goalwire.execution.ready_queue import CallbackGroup

if TYPE_CHECKING:
    from collections.abc import Sequence

    from goalwire.execution.ready_queue import CallbackSource

__all__ = [
    'CallbackGroup',
    'MutuallyExclusiveCallbackGroup',
    'ReentrantCallbackGroup',
    'check_group',
]


class ReentrantCallbackGroup(CallbackGroup):
    """A group whose callbacks may all run at the same time; one callback may also run several times
    at once.
    """

    def can_execute(self, entity: object) -> bool:  # noqa: ARG002
        """Return True."""
        return True

    def beginning_execution(self, entity: object) -> bool:  # noqa: ARG002
        """Return True."""
        return True

    def ending_execution(self, entity: object) -> None:
        """Do nothing: this group keeps no state."""

    begin = beginning_execution
    ended = ending_execution

    def park(self, source: CallbackSource) -> None:
        """Post `source` again. Executors do not call this, since every callback of this group may start."""
        source.work_queue.post(source)


class MutuallyExclusiveCallbackGroup(CallbackGroup):
    """Runs one callback at a time. Work that comes meanwhile is parked here, and no thread waits for it.

    No lock blocks, and no parked work is forgotten, because both sides act in opposite order. `park` appends
    the work, then looks whether the group is still busy. `ending_execution` frees the group, then looks for
    parked work. One of them sees the other.
    """

    exclusive = True

    def __init__(self) -> None:
        super().__init__()
        self._busy = allocate_lock()
        self._parked: deque[CallbackSource] = deque()

    def can_execute(self, entity: object) -> bool:  # noqa: ARG002
        """Tell whether the group is free."""
        return not self._busy.locked()

    def beginning_execution(self, entity: object) -> bool:
        """Take the group for `entity`; False while another callback runs."""
        if self._busy.acquire(blocking=False):
            self._active = entity
            return True
        return False

    def ending_execution(self, entity: object) -> None:
        """Free the group, if `entity` has it, and post the next parked work."""
        if self._active is not entity:
            return
        self._active = None
        self._busy.release()
        if self._parked:
            self._post_next()

    begin = beginning_execution
    ended = ending_execution

    @property
    def parked(self) -> Sequence[CallbackSource]:
        return copy_of(self._parked)

    def park(self, source: CallbackSource) -> None:
        """Keep `source` until the group is free."""
        self._parked.append(source)
        if not self._busy.locked():
            self._post_next()

    def _post_next(self) -> None:
        """Post the oldest parked work.

        If no executor runs the node of that work, the work does not take the group. So the next parked work
        is posted, too.
        """
        while self._parked:
            try:
                source = self._parked.popleft()
            except IndexError:
                return
            source.work_queue.post(source)
            if source.work_queue.attached:
                return


def check_group(group: object) -> CallbackGroup:
    """Return `group`; raises AttributeError, as rclpy does, for anything but a callback group."""
    if not isinstance(group, CallbackGroup):
        raise AttributeError(  # noqa: TRY004 - as rclpy
            f"'{type(group).__name__}' object has no attribute 'add_entity': callback_group takes a "
            'MutuallyExclusiveCallbackGroup or a ReentrantCallbackGroup'
        )
    return group
