"""Callback groups: which callbacks may run beside each other (rclpy.callback_groups)."""

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
    """Its callbacks run beside each other, and beside themselves."""

    def can_execute(self, entity: object) -> bool:  # noqa: ARG002
        """Always True."""
        return True

    def beginning_execution(self, entity: object) -> bool:  # noqa: ARG002
        """Always True."""
        return True

    def ending_execution(self, entity: object) -> None:
        """Nothing has to be noted."""

    begin = beginning_execution
    ended = ending_execution

    def park(self, source: CallbackSource) -> None:
        """Never needed; posting again is right all the same."""
        source.work_queue.post(source)


class MutuallyExclusiveCallbackGroup(CallbackGroup):
    """One callback at a time. What comes meanwhile waits in here, without keeping a thread busy.

    It takes no blocking lock. Who parks work appends it, then looks whether the group is still busy; who
    ends frees the group, then looks for parked work: one of them sees the other.
    """

    exclusive = True

    def __init__(self) -> None:
        super().__init__()
        self._busy = allocate_lock()
        self._parked: deque[CallbackSource] = deque()

    def can_execute(self, entity: object) -> bool:  # noqa: ARG002
        """Whether no callback runs."""
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
        """Post the oldest parked work, and more while it goes to nodes that no executor runs."""
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
