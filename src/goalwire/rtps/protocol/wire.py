"""The common base of writers and readers: sending packets, timers, a lock, and events for listeners."""

from __future__ import annotations

import heapq
from collections.abc import Callable
from functools import partial
from itertools import count
from operator import call
from typing import TypeVar

from goalwire.concurrency.critical_section import CriticalSection
from goalwire.concurrency.ordered_dispatcher import OrderedDispatcher
from goalwire.fault_reports import report_failure
from goalwire.rtps.protocol.messages import header
from goalwire.rtps.protocol.primitives import Address, PacketParts

T = TypeVar('T')

FOREVER = float('inf')


class Timer:
    """Calls a function once at its time, unless the timer is cancelled before."""

    __slots__ = ('function', 'when')

    def __init__(self, when: float, function: Callable[[], None]) -> None:
        self.when = when
        self.function: Callable[[], None] | None = function

    def cancel(self) -> None:
        """Cancel the timer: its function will not be called."""
        self.function = None


class Timers:
    """The timers of a participant, by time."""

    def __init__(self) -> None:
        self.heap: list[tuple[float, int, Timer]] = []
        """The timers, with cancelled ones that are not due yet."""
        self._next = count().__next__

    def at(self, when: float, function: Callable[[], None]) -> Timer:
        """Return a new timer that calls `function` at a time."""
        timer = Timer(when, function)
        heapq.heappush(self.heap, (when, self._next(), timer))
        return timer

    def next_due(self) -> float:
        """Return when the next timer is due; FOREVER if there is none."""
        heap = self.heap
        while heap and heap[0][2].function is None:
            heapq.heappop(heap)
        return heap[0][0] if heap else FOREVER

    def run(self, now: float) -> None:
        """Call the functions of the due timers."""
        while self.next_due() <= now:
            timer = heapq.heappop(self.heap)[2]
            function, timer.function = timer.function, None
            if function is not None:
                function()


class Watch:
    """Notices when nothing was heard for a while.

    A sign of life is noted by one assignment, without a new timer.
    """

    __slots__ = ('_on_silence', '_period', '_timer', '_wire', 'heard')

    def __init__(self, wire: Wire, period_s: float, on_silence: Callable[[], None]) -> None:
        """`on_silence` is called once for each `period_s` of silence, until `stop`."""
        self._wire = wire
        self._period = period_s
        self._on_silence = on_silence
        self.heard = wire.clock()
        self._timer = wire.timers.at(self.heard + period_s, self._look)

    def _look(self) -> None:
        now = self._wire.clock()
        if self.heard + self._period <= now:
            self.heard = now
            self._on_silence()
        if self._period:
            self._timer = self._wire.timers.at(self.heard + self._period, self._look)

    def stop(self) -> None:
        """Stop watching."""
        self._period = 0.0
        self._timer.cancel()


class Wire:
    """Everything that a participant's writers and readers need from outside.

    All changes of writers and readers run in `run`, one at a time. Users' callbacks go through `tell`: they
    run after the change, in order, without any lock held.
    """

    def __init__(
        self,
        prefix: bytes,
        *,
        clock: Callable[[], float],
        wall_clock_ns: Callable[[], int],
        send: Callable[[bytes, Address], None],
        send_parts: Callable[[PacketParts, Address], None] | None = None,
        on_sooner: Callable[[], None] = lambda: None,
        on_acknowledged: Callable[[], None] | None = None,
    ) -> None:
        """`send` never blocks; a packet that it cannot send is lost, as on any network. `send_parts` does the
        same for a packet in parts; if it is None, the parts are joined and given to `send`.

        `on_sooner` is called when a new timer is due before all others. `on_acknowledged` is called when
        readers have acknowledged samples, in order with users' callbacks, to wake callers that wait for
        acknowledgements.
        """
        self.prefix = prefix
        self.head = header(prefix)
        self.clock = clock
        self.wall_clock_ns = wall_clock_ns
        self.send_packet = send
        self.send_packet_parts = send_parts
        self.on_acknowledged = on_acknowledged
        self.timers = Timers()
        self.section = CriticalSection()
        self.next_due = FOREVER
        self.kept = 0
        """Bytes of the samples that readers keep because they cannot deliver them yet."""
        self._on_sooner = on_sooner
        self._told: OrderedDispatcher[Callable[[], object]] = OrderedDispatcher(call, _report)
        self.post = self._told.post
        """`tell` for a function without arguments."""
        self._local: list[bytes] = []
        """Packets for this participant's own readers and writers."""

    def run(self, do: Callable[[], T], otherwise: T) -> T:
        """Call a function while no other thread is in `run`, and return its result.

        If this thread is in `run` already, for example because a signal handler interrupted it there, the
        function is called later, and `otherwise` is returned now.
        """
        # hot path: `CriticalSection.run` and the check of `items`, inlined, save three calls for each sample
        section, done = self.section, otherwise
        with section.lock:
            if section.is_busy:
                section.late.append(partial(self._run_late, do))
                return otherwise
            if section.late:
                section.run_late()
            try:
                section.is_busy = True
                done = do()
                while self._local:
                    self.loop_back()
            finally:
                section.is_busy = False
                if section.late:
                    section.run_late()
        heap = self.timers.heap
        if heap and heap[0][0] < self.next_due:
            due = self.timers.next_due()
            if due < self.next_due:
                self.next_due = due
                self._on_sooner()
        if self._told.items:
            self._told.drain()
        return done

    def _run_late(self, do: Callable[[], object]) -> None:
        do()
        while self._local:
            self.loop_back()

    def advance(self) -> None:
        """Run the due timers."""
        self.next_due = FOREVER
        self.run(partial(self.timers.run, self.clock()), None)

    def tell(self, function: Callable[..., object], *arguments: object) -> None:
        """Call a user's callback after the present change, without a lock."""
        self.post(partial(function, *arguments))

    def refuse(self, kind: str, reason: str) -> None:
        """Count ignored data. This placeholder does nothing; a participant replaces it by its counter."""

    def send(self, packet: bytes, address: Address) -> None:
        """Send a packet. An address without a port means this participant itself."""
        if address[1]:
            self.send_packet(packet, address)
        else:
            self._local.append(packet)

    def send_parts(self, parts: PacketParts, address: Address) -> None:
        """Send a packet that is given in parts, as `send` does."""
        if self.send_packet_parts is not None and address[1]:
            self.send_packet_parts(parts, address)
        else:
            self.send(b''.join(parts), address)

    def loop_back(self) -> None:
        """Receive the packets that were sent to this participant itself."""
        packets, self._local = self._local, []
        for packet in packets:
            self.receive_own(packet)

    def receive_own(self, packet: bytes) -> None:
        """Receive a packet that this participant sent to itself.

        This placeholder does nothing; a participant replaces it.
        """


LOCAL: Address = ('', 0)
"""The address of a participant's own endpoints."""


def _report(error: Exception) -> None:
    report_failure('RTPS listener', error)
