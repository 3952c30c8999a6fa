"""What an executor runs."""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from collections.abc import Callable

    from goalwire.execution.callback_groups import CallbackGroup
    from goalwire.execution.node_work_queue import NodeWorkQueue

_NOTHING_MORE: Callable[[], object] = bool
"""Does nothing, and enters no function of Python's for it."""


class CallbackSource:
    """A source of callbacks: a subscription's event queue, a timer, a task, an asyncio runner.

    Each turn through an executor's queue runs one callback, so sources take turns fairly.
    """

    __slots__ = ('__weakref__', 'group', 'work_queue')

    def __init__(self, work_queue: NodeWorkQueue, group: CallbackGroup | None) -> None:
        self.work_queue = work_queue if group is None or group.work_queue is None else group.work_queue
        self.group = group

    @property
    def entity(self) -> object:
        """Whose callbacks these are: what an executor written by a user is told."""
        return self

    @property
    def backlog(self) -> int:
        """How many events wait here."""
        return 1

    def run(self) -> object:
        """Take one event and run the user's callback for it.

        Where the callback is `async def`, return the coroutine it made: the executor runs it as an asyncio
        task and holds the group until that ends. Any other value means nothing. What this raises comes out
        of spin.
        """
        raise NotImplementedError

    settle = staticmethod(_NOTHING_MORE)
    """Called when the callback has ended and the group is free: post again if there is more to do."""
