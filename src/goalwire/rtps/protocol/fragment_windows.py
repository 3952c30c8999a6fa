"""Sends a writer's large samples in windows of a few fragments, since readers' socket buffers are small.

The next window is sent when a reader asks for it, or after a moment. As long as no reader lacks a fragment
that was sent, each window is twice as large as the last. After a loss the window is halved, and grows again
only after many windows without a loss. Readers of this implementation on this host announce the size of their
buffers; then the first window already fills a share of the smallest buffer.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Callable, Iterable
from typing import NamedTuple

from goalwire.rtps.protocol import bounds
from goalwire.rtps.protocol.fragments import ON_THE_WAY_S, cut, fragment_count
from goalwire.rtps.protocol.history import Change
from goalwire.rtps.protocol.messages import HeartbeatFrag, NackFrag, info_ts
from goalwire.rtps.protocol.primitives import UNKNOWN_ENTITY, encode_time
from goalwire.rtps.protocol.reader_proxy import HEARTBEAT_S, ReaderProxy
from goalwire.rtps.protocol.wire import Timer
from goalwire.rtps.protocol.writer_output import WriterOutput

WINDOW, WINDOW_PACKETS = 120_000, 11
"""Bytes, and fragments, that are sent before a reader asks for more, or WINDOW_S is over. A socket's default
buffer on Linux takes three packets of 60,000 bytes, or twelve of 8,000."""
WINDOW_S = 0.0005
LARGEST_WINDOW = 1 << 20
"""The largest window in bytes: without a loss each window is twice the last one."""
ROOM_USED = 3 / 4
"""The part of a reader's buffer that a window may fill; the rest is for other writers' samples."""
FORGIVEN = 16
"""After so many windows without a loss the largest window is doubled again."""
WINDOWS_KEPT = 16
"""How many windows are remembered with the time of sending."""


class _Window(NamedTuple):
    """Fragments of one sample that were sent together."""

    number: int
    """The number of the sample."""
    first: int
    end: int
    """The number after the last fragment."""
    when: float


def _fragments_of(window: int, change: Change) -> int:
    """Return how many fragments of a sample fit into a window of `window` bytes."""
    return max(1, min(window // change.fragment_size, WINDOW_PACKETS * window // WINDOW))


class FragmentWindows:
    """The queued samples of one writer; the first is being sent. Methods are called inside `Wire.run`."""

    def __init__(self, output: WriterOutput, depth: int, on_sent: Callable[[], None]) -> None:
        """Queue at most `depth` samples (0: any number). `on_sent` is called after each window."""
        self._output = output
        self._depth = depth
        self._on_sent = on_sent
        self.unsent_size = 0
        """Bytes of the queued samples."""
        self._next_fragment = 1
        self._window, self._largest_window = WINDOW, LARGEST_WINDOW
        self._rooms: int | None = None
        """The smallest buffer that a reader on this host has announced; 0 if a reader announces none."""
        self._lossless = 0
        """How many windows have been received since the last loss."""
        self._timer: Timer | None = None
        self._sent: deque[_Window] = deque(maxlen=WINDOWS_KEPT)
        """The last windows of fragments."""

    def note_room(self, room: int) -> None:
        """Note a new reader, whose socket buffer holds `room` bytes; 0: unknown.

        If all readers announce their room, the first window already fills a share of it, and need not grow.
        """
        self._rooms = room if self._rooms is None else min(self._rooms, room)
        self._window = min(max(WINDOW, int(self._rooms * ROOM_USED)), self._largest_window)

    def queue(self, change: Change) -> None:
        """Queue a sample behind the earlier samples."""
        output = self._output
        depth = self._depth
        if depth and len(output.unsent) > depth:  # the first sample is being sent, so the second is dropped
            self.unsent_size -= output.unsent[1].size
            del output.unsent[1]
        output.unsent.append(change)
        self.unsent_size += change.size
        if self._timer is None or self._timer.when <= output.wire.clock():
            self._send_window()

    def _send_window(self) -> None:
        """Send queued samples, at most one window."""
        output = self._output
        if self._timer is not None:
            self._timer.cancel()
            self._timer = None
        left = self._window
        while output.unsent and left > 0:
            change = output.unsent[0]
            if change.size > output.fragment_size and self._next_fragment == 1:
                change.fragment_size = output.fragment_size
            if not change.fragment_size:
                self._take_unsent()
                left -= change.size
                output.send_fresh(change)
                continue
            left -= self._send_fragments(change)
            if self._next_fragment <= fragment_count(change.size, change.fragment_size):
                self._tell_fragments(change)
                break
            self._take_unsent()
            for proxy in output.receivers(change):
                proxy.last = change.number
                if proxy.is_reliable:
                    output.send_to(proxy, output.heartbeat(proxy))
        if output.unsent:
            self._timer = output.wire.timers.at(output.wire.clock() + WINDOW_S, self._send_window)
        self._on_sent()

    def _take_unsent(self) -> None:
        """Remove the first sample, which has been sent, from the queue."""
        self.unsent_size -= self._output.unsent.popleft().size
        self._next_fragment = 1

    def _send_fragments(self, change: Change) -> int:
        """Send the next fragments of a sample, at most one window; return their size in bytes."""
        output = self._output
        first = self._next_fragment
        end = min(
            first + _fragments_of(self._window, change), fragment_count(change.size, change.fragment_size) + 1
        )
        stamp = info_ts(encode_time(change.time))
        if output.is_addressed:
            for proxy in output.receivers(change):
                if first == 1:
                    gap = output.gap_before(proxy, change.number)
                    if gap:
                        output.send_to(proxy, gap)
                before = output.wire.head + proxy.asks + stamp
                for fragment in range(first, end):
                    packet = cut(before, change, proxy.entity_id, output.entity_id, fragment)
                    output.wire.send_parts(packet, proxy.address)
        else:
            before = output.wire.head + stamp
            for fragment in range(first, end):
                packet = cut(before, change, UNKNOWN_ENTITY, output.entity_id, fragment)
                for address in output.addresses:
                    output.wire.send_parts(packet, address)
        self._next_fragment = end
        self._sent.append(_Window(change.number, first, end, output.wire.clock()))
        return (end - first) * change.fragment_size

    def _tell_fragments(self, change: Change) -> None:
        """Tell reliable readers which fragments have been sent, so that they request those that they lack."""
        output = self._output
        count = fragment_count(change.size, change.fragment_size)
        for proxy in output.receivers(change):
            if proxy.is_reliable:
                output.counter += 1
                told = HeartbeatFrag(proxy.entity_id, output.entity_id, change.number, count, output.counter)
                output.send_to(proxy, told.encode())

    def on_nack_frag(self, proxy: ReaderProxy, nack: NackFrag) -> None:
        """Send the fragments that a reader asks for, at most one window. Called inside `Wire.run`."""
        output = self._output
        if nack.counter == proxy.frag_counter:
            return
        proxy.frag_counter = nack.counter
        proxy.interval = HEARTBEAT_S
        missing = nack.missing.numbers()
        begun = output.unsent[0] if output.unsent else None
        if begun is not None and begun.number == nack.number:
            sent = self._next_fragment
            if missing and missing[0] >= sent:
                self._grow()
            if missing and missing[-1] >= sent:
                self._send_window()
            missing = [fragment for fragment in missing if fragment < sent]
        change = output.history.changes.get(nack.number)
        if missing and self._is_on_the_way(nack.number, missing):
            return
        if change is not None and change.fragment_size and missing:
            self._window = self._largest_window = max(WINDOW, self._window // 2)
            self._lossless = 0
            output.note_loss()
            self.send_some(proxy, change, missing)
            output.send_to(proxy, output.heartbeat(proxy))

    def _is_on_the_way(self, number: int, missing: list[int]) -> bool:
        """Return True if a reader requests a whole window that was sent a moment ago: the two have crossed.

        A full buffer loses only a part of a window, so a request for all of it does not mean a loss. If the
        window is lost after all, the reader asks again.
        """
        long_ago = self._output.wire.clock() - ON_THE_WAY_S
        for window in self._sent:
            if (window.number, window.first) == (number, missing[0]) and window.when > long_ago:
                size = min(window.end - window.first, bounds.SET_BITS)
                return len(missing) >= size and missing[size - 1] == window.first + size - 1
        return False

    def _grow(self) -> None:
        """Note that a reader has a whole window and asks for the next; enlarge the window."""
        self._lossless += 1
        if self._lossless % FORGIVEN == 0:
            self._largest_window = min(2 * self._largest_window, LARGEST_WINDOW)
        self._window = min(2 * self._window, self._largest_window)
        if self._window == LARGEST_WINDOW:
            self._output.trust()

    def send_some(self, proxy: ReaderProxy, change: Change, fragments: Iterable[int]) -> None:
        """Send some fragments of a sample to one reader, at most one window."""
        output = self._output
        count = fragment_count(change.size, change.fragment_size)
        before = output.wire.head + proxy.asks + info_ts(encode_time(change.time))
        for fragment in list(fragments)[: _fragments_of(WINDOW, change)]:
            if 0 < fragment <= count:
                packet = cut(before, change, proxy.entity_id, output.entity_id, fragment)
                output.wire.send_parts(packet, proxy.address)

    def stop(self) -> None:
        """Send nothing more."""
        if self._timer is not None:
            self._timer.cancel()
        self._output.unsent.clear()
