"""Threads that wait until the other side of a link has taken the queued bytes."""

from __future__ import annotations

from functools import partial
from time import monotonic

from goalwire.concurrency.critical_section import CriticalSection
from goalwire.concurrency.leader_followers import LeaderFollowers
from goalwire.concurrency.poller import Poller
from goalwire.concurrency.wire_poller import SleepingThread
from goalwire.zenoh.io.socket_link import SocketLink
from goalwire.zenoh.protocol import bounds
from goalwire.zenoh.protocol.outgoing import QUEUE_LIMIT
from goalwire.zenoh.protocol.primitives import UNRESPONSIVE

ROOM_S = 60.0
"""How long a message waits for room before its link is closed."""


class Backpressure:
    """Lets the threads of one session wait for room on its links."""

    def __init__(self, wire_poller: LeaderFollowers, section: CriticalSection, poller: Poller) -> None:
        """`section` guards the session's tables."""
        self._wire_poller = wire_poller
        self._section = section
        self._poller = poller

    def may_block(self) -> bool:
        """True if the calling thread may wait: it neither reads sockets nor changes the session's tables."""
        return not (self._wire_poller.leads() or self._section.is_entered())

    def wait_for_room(self, socket_link: SocketLink, is_answer: bool) -> None:
        """Wait until a link has room. The thread that reads does not wait, as only reading makes room.

        A message may wait for ROOM_S. An answer waits only as long as the asking side goes on reading.
        """
        if not self.may_block():
            return
        outgoing = socket_link.outgoing
        room, patience = (bounds.UNREAD_LIMIT, bounds.UNREAD_S) if is_answer else (QUEUE_LIMIT, ROOM_S)
        deadline, size = monotonic() + patience, outgoing.queue.size
        sleeper = SleepingThread()
        socket_link.waiting.add(sleeper)
        try:
            while outgoing.is_open and outgoing.queue.size > room:
                left = deadline - monotonic()
                if left <= 0 and is_answer and outgoing.queue.size <= size - bounds.PROGRESS:
                    deadline, size = monotonic() + patience, outgoing.queue.size
                elif left <= 0:
                    self._poller.call(partial(self._close_full, socket_link, patience))
                    return
                socket_link.watch_room()
                self._wire_poller.wait(sleeper, int(left * 1e9))
        finally:
            socket_link.waiting.discard(sleeper)

    def _close_full(self, socket_link: SocketLink, patience: float) -> None:
        socket_link.end(f'nothing was taken for {patience:g} s', UNRESPONSIVE, is_fault=True)

    def drain(self, socket_links: list[SocketLink], patience_s: float) -> None:
        """Wait until the other sides have taken all queued bytes, but at most for a given time."""
        deadline = monotonic() + patience_s
        sleeper = SleepingThread()
        for each in socket_links:
            each.waiting.add(sleeper)
        while any(each.outgoing.is_open and each.outgoing.queue.size for each in socket_links):
            left = deadline - monotonic()
            if left <= 0:
                return
            for each in socket_links:
                each.watch_room()
            self._wire_poller.wait(sleeper, int(left * 1e9))
