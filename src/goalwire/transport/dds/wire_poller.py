"""Who waits for a DDS session's messages: the waitset of its readers, and the pattern Leader/Followers."""

from __future__ import annotations

from collections.abc import Callable

from goalwire.transport.dds.waitset import WaitSet
from goalwire.transport.dds.wire import Participant
from goalwire.transport.wire_poller import LeaderFollowers


class DdsWirePoller(LeaderFollowers):
    """The waitset of one session's readers, and who waits in it."""

    def __init__(self, participant: Participant, name: str) -> None:
        self._conditions = WaitSet(participant, name)
        super().__init__(self._conditions, name)

    def watch(self, condition: int, handler: Callable[[], object]) -> None:
        """Call `handler` while the condition is true, on the thread that leads; `unwatch` ends that."""
        self.start()
        self._conditions.watch(condition, handler)

    def unwatch(self, condition: int) -> None:
        """Call no more for this condition; an unknown one is no error."""
        self._conditions.unwatch(condition)
