"""Callback groups: which callbacks may run beside each other (rclpy.callback_groups)."""

from __future__ import annotations

from _thread import allocate_lock
from collections import deque
from typing import TYPE_CHECKING
from weakref import WeakSet

if TYPE_CHECKING:
    from collections.abc import Sequence

    from goalwire.execution.callback_source import CallbackSource
    from goalwire.execution.node_work_queue import NodeWorkQueue


class CallbackGroup:
    """The entities whose callbacks one rule governs."""

    exclusive = False
    """Whether one callback at a time may run."""

    foreign = False
    """Whether a program has written its rule."""

    work_queue: NodeWorkQueue | None = None
    """Where its members' work goes, if not to their node's executor; to be set before they are made."""

    def __init__(self) -> None:
        self.entities: WeakSet[object] = WeakSet()
        self._active: object = None

    def __init_subclass__(cls) -> None:
        if 'begin' not in vars(cls) and _RULE & vars(cls).keys():
            cls.foreign = True
            cls.begin = CallbackGroup.begin  # type: ignore[method-assign]  # where a quicker one was inherited
            cls.ended = CallbackGroup.ended  # type: ignore[method-assign]

    def add_entity(self, entity: object) -> None:
        """Make `entity` a member. Raises TypeError for what cannot be referenced weakly."""
        self.entities.add(entity)

    def has_entity(self, entity: object) -> bool:
        """Whether `entity` is a member."""
        return entity in self.entities

    def can_execute(self, entity: object) -> bool:
        """Whether a callback of `entity` may start now."""
        raise NotImplementedError

    def beginning_execution(self, entity: object) -> bool:
        """Note that a callback of `entity` starts; False where it may not."""
        raise NotImplementedError

    def ending_execution(self, entity: object) -> None:
        """Note that a callback of `entity` has ended."""
        raise NotImplementedError

    def begin(self, source: CallbackSource, /) -> bool:
        """Ask the rule whether a callback of `work` may start, and note that it does."""
        entity = source.entity
        return self.can_execute(entity) and self.beginning_execution(entity)

    def ended(self, source: CallbackSource, /) -> None:
        """Note that a callback of `work` has ended."""
        self.ending_execution(source.entity)

    @property
    def active_entity(self) -> object:
        """Whose callback runs in an exclusive group, or None."""
        return self._active

    @property
    def parked(self) -> Sequence[CallbackSource]:
        """What waits for the running callback to end."""
        return ()

    def park(self, source: CallbackSource) -> None:
        """Keep `work`, which may not start now, and post it again when it may."""
        raise NotImplementedError


_RULE = {'can_execute', 'beginning_execution', 'ending_execution'}
"""What a group written by a program replaces."""


class ReentrantCallbackGroup(CallbackGroup):
    """Its callbacks run beside each other, and beside themselves."""

    def can_execute(self, entity: object) -> bool:  # noqa: ARG002
        """Always."""
        return True

    def beginning_execution(self, entity: object) -> bool:  # noqa: ARG002
        """Always."""
        return True

    def ending_execution(self, entity: object) -> None:
        """Nothing to note."""

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
        return self._parked.copy()

    def park(self, source: CallbackSource) -> None:
        """Keep `work` until the group is free."""
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


def checked_group(group: object) -> CallbackGroup:
    """Return `group`; raises AttributeError, as rclpy does, where it is none."""
    if not isinstance(group, CallbackGroup):
        raise AttributeError(  # noqa: TRY004 - as rclpy
            f"'{type(group).__name__}' object has no attribute 'add_entity': callback_group takes a "
            'MutuallyExclusiveCallbackGroup or a ReentrantCallbackGroup'
        )
    return group
