"""A writer of one topic: it sends samples at once, and keeps them for readers that may request them again.

A fresh sample goes to all readers, in one packet for each address (`writer_output`). The sample is kept for
reliable readers that have not acknowledged it (`writer_repairs`), and for readers that come later (transient
local). A sample that is too large for a packet is sent in fragments (`fragment_windows`).
"""

from __future__ import annotations

from collections.abc import Callable
from functools import partial

from goalwire.rtps.protocol.announcements import EndpointData
from goalwire.rtps.protocol.fragment_windows import FragmentWindows
from goalwire.rtps.protocol.fragments import FRAGMENT_SIZES, FragmentSizes
from goalwire.rtps.protocol.history import Change, HistoryCache
from goalwire.rtps.protocol.lingering import Lingering, is_delivered
from goalwire.rtps.protocol.primitives import INFINITE, NS, Address
from goalwire.rtps.protocol.qos import MANUAL_BY_TOPIC, RELIABLE, TRANSIENT_LOCAL
from goalwire.rtps.protocol.reader_proxy import MOST_PATIENCE_S, ReaderProxy
from goalwire.rtps.protocol.wire import Watch, Wire
from goalwire.rtps.protocol.writer_output import WriterOutput
from goalwire.rtps.protocol.writer_repairs import Repairs

MOST_UNACKNOWLEDGED = 1024
MOST_UNACKNOWLEDGED_SIZE = 16 << 20
"""The number of samples, and their bytes, at which a writer with KEEP_ALL is full."""


class WriterListener:
    """The callbacks of a writer. Every method is called without any lock held."""

    def on_matched(self, reader: EndpointData) -> None:
        """Called when a reader has been matched: the reader gets the samples from now on."""

    def on_answered(self, reader: EndpointData) -> None:
        """Called at a reliable reader's first answer: it knows the writer, and will miss no new sample."""

    def on_unmatched(self, reader: EndpointData) -> None:
        """Called when a matched reader has gone."""

    def on_incompatible(self, reader: EndpointData, policy: str) -> None:
        """Called if a reader of the topic requests more in the policy `policy` than the writer offers."""

    def on_room(self) -> None:
        """Called when a writer that was full has room again."""

    def on_deadline_missed(self) -> None:
        """Called if no sample was written within the deadline."""

    def on_liveliness_lost(self) -> None:
        """Called if the liveliness lease has ended without a sample or assertion."""


class Writer:
    """A writer of one topic. Methods may be called on any thread, unless they say otherwise."""

    def __init__(
        self,
        wire: Wire,
        data: EndpointData,
        listener: WriterListener,
        *,
        is_keyed: bool = False,
        fragment_sizes: FragmentSizes = FRAGMENT_SIZES,
    ) -> None:
        """Make a writer. Only built-in writers are made with `is_keyed`."""
        self.data = data
        self.listener = listener
        self.entity_id = data.entity_id
        self.history = HistoryCache(data.qos.depth, is_keyed=is_keyed)
        self._wire = wire
        self._is_reliable = data.qos.reliability == RELIABLE
        self._keeps_all = not data.qos.depth
        self._expires = data.qos.lifespan < INFINITE
        self._is_watched = False
        """True if it has a deadline or a liveliness lease to watch."""
        self._is_local_history = data.qos.durability >= TRANSIENT_LOCAL
        self._was_full = False
        self._output = WriterOutput(wire, data, self.history, fragment_sizes)
        self._windows = FragmentWindows(self._output, data.qos.depth, self._on_window_sent)
        self._repairs = Repairs(
            self._output, self._windows, data.qos, self._on_acknowledged, listener.on_answered
        )
        self.readers = self._output.readers
        """The readers that get its samples, by their GUIDs."""
        self.on_acknack = self._repairs.on_acknack
        self.on_nack_frag = self._windows.on_nack_frag
        self._deadline: Watch | None = None
        self._lease: Watch | None = None
        self._lingering: Lingering | None = None

    def start(self) -> None:
        """Watch the writer's deadline and lease from now on. Called inside `Wire.run`."""
        wire, qos, listener = self._wire, self.data.qos, self.listener
        self._is_watched = min(qos.deadline, qos.lease) < INFINITE
        if qos.deadline < INFINITE:
            self._deadline = Watch(wire, qos.deadline / NS, partial(wire.tell, listener.on_deadline_missed))
        if qos.liveliness == MANUAL_BY_TOPIC and qos.lease < INFINITE:
            self._lease = Watch(wire, qos.lease / NS, partial(wire.tell, listener.on_liveliness_lost))

    @property
    def last(self) -> int:
        """The number of the last sample."""
        return self._output.last

    # ---- writing

    def write(
        self, payload: bytes, *, qos: bytes = b'', to: bytes | None = None, time_ns: int | None = None
    ) -> int | None:
        """Send a sample and return its number; None if the writer is full: then wait for `on_room`.

        `qos` is inline QoS, `to` the GUID of the only reader to get it. If a signal handler interrupts this
        method and calls it again, it gets 0, and its sample is sent right after the handler.
        """
        otherwise: int | None = 0
        return self._wire.run(partial(self.add, payload, qos, to, time_ns), otherwise)

    def add(
        self,
        payload: bytes | None,
        qos: bytes = b'',
        to: bytes | None = None,
        time_ns: int | None = None,
        key: bytes = b'',
        is_key: bool = False,
    ) -> int | None:
        """Write a sample, as `write` does, but inside `Wire.run`."""
        addressee = self.readers.get(to) if to is not None else None
        output, history = self._output, self.history
        may_be_full = len(history.changes) >= MOST_UNACKNOWLEDGED or history.size >= MOST_UNACKNOWLEDGED_SIZE
        if (
            self._keeps_all
            and (may_be_full or output.unsent)
            and (self.is_full() if addressee is None else self._is_full_for(addressee))
        ):
            self._was_full = True
            self._repairs.expect_answers()
            return None
        number = output.last + 1
        change = Change(number, time_ns or self._wire.wall_clock_ns(), payload, qos, to, key, is_key)
        if to is not None and not output.is_addressed:
            output.begin_addressing()
        output.last = number
        if self._is_watched:
            self._note_alive()
        if output.reliable or self._is_local_history:
            if self._expires:
                history.expire(change.time - self.data.qos.lifespan)
            history.add(change)
            if addressee is not None and addressee.is_reliable:
                addressee.addressed.append(change)
                addressee.addressed_size += change.size
        else:
            self._repairs.acked = number
        if not self.readers:
            history.forget_gone(number)
            return number
        if output.unsent or (payload is not None and len(payload) > output.fragment_size):
            self._windows.queue(change)
        else:
            output.send_fresh(change)
            if self._repairs.timer is None and output.reliable:
                self._repairs.expect_answers(is_patient=True)
        return number

    def assert_liveliness(self) -> None:
        """Assert that the writer lives, to readers that watch its liveliness."""
        self._wire.run(self._assert, None)

    def _assert(self) -> None:
        self._note_alive()
        for proxy in self.readers.values():
            self._output.send_to(proxy, self._output.heartbeat(proxy, is_final=True, asserts=True))

    def _note_alive(self) -> None:
        if self._deadline is not None:
            self._deadline.heard = self._wire.clock()
        if self._lease is not None:
            self._lease.heard = self._wire.clock()

    # ---- waiting for readers

    def is_full(self) -> bool:
        """True if a writer with KEEP_ALL must wait for its readers."""
        if self.data.qos.depth:
            return False
        if self._windows.unsent_size >= MOST_UNACKNOWLEDGED_SIZE:
            return True
        is_behind = self._output.last - self._repairs.acked >= MOST_UNACKNOWLEDGED
        return bool(self._output.reliable) and (
            is_behind or self._count_unacked() >= MOST_UNACKNOWLEDGED_SIZE
        )

    def _is_full_for(self, proxy: ReaderProxy) -> bool:
        """Return True if a writer with KEEP_ALL has no room for another sample to only this reader."""
        return (
            self._windows.unsent_size >= MOST_UNACKNOWLEDGED_SIZE
            or len(proxy.addressed) >= MOST_UNACKNOWLEDGED
            or proxy.addressed_size >= MOST_UNACKNOWLEDGED_SIZE
        )

    def ask_now(self) -> None:
        """Ask its readers at once for acknowledgements. Called inside `Wire.run`."""
        self._repairs.ask_now()

    def is_acknowledged(self) -> bool:
        """Tell whether all readers that have ever answered have acknowledged all their samples."""
        return is_delivered(self._output)

    def is_acknowledged_by_all(self) -> bool:
        """True if all reliable readers have acknowledged all their samples. May be called on any thread."""
        output = self._output
        return all(output.has_all(proxy) for proxy in tuple(output.reliable))

    def _count_unacked(self) -> int:
        if not self._is_local_history:
            return self.history.size
        changes, acked = self.history.changes, self._repairs.acked
        return sum(changes[number].size for number in range(acked + 1, self.last + 1) if number in changes)

    def _on_window_sent(self) -> None:
        if not self._output.unsent:
            self._offer_room()
        if self._output.reliable:
            self._repairs.expect_answers()

    def _on_acknowledged(self) -> None:
        if self._wire.on_acknowledged is not None:
            self._wire.tell(self._wire.on_acknowledged)
        self._offer_room()
        if self._lingering is not None:
            self._lingering.note_acknowledged()

    def _offer_room(self) -> None:
        """Report room if the writer was full; the room may be for samples to only one reader."""
        if self._was_full and (self._output.is_addressed or not self.is_full()):
            self._was_full = False
            self._wire.tell(self.listener.on_room)

    # ---- matching with readers

    def match(
        self,
        reader: EndpointData,
        address: Address,
        *,
        is_near: bool,
        room: int = 0,
        pushes: bool = False,
    ) -> None:
        """Add a reader. Called inside `Wire.run`.

        `room` is the `receive_buffer` of the reader's participant. With `pushes` the reader gets all samples
        at once, without a request.
        """
        output = self._output
        is_reliable = self._is_reliable and reader.qos.reliability == RELIABLE
        wants_history = self._is_local_history and reader.qos.durability >= TRANSIENT_LOCAL
        if wants_history and self.data.qos.lifespan < INFINITE:
            self.history.expire(self._wire.wall_clock_ns() - self.data.qos.lifespan)
        start = self.history.first(output.last) if wants_history else output.last + 1
        proxy = ReaderProxy(reader, address, is_reliable, start)
        if output.is_addressed or wants_history:
            proxy.last = output.last
        self.readers[reader.guid] = proxy
        if not is_near:
            output.note_far()
        elif self.data.topic:
            proxy.most_patience = MOST_PATIENCE_S
        self._windows.note_room(room if is_near else 0)
        output.note_readers()
        self._wire.tell(self.listener.on_matched, reader)
        if not is_reliable:
            return
        proxy.due = self._wire.clock() + proxy.interval
        if pushes and start <= output.last:
            self._repairs.push(proxy, list(self.history.changes))
        else:
            output.send_to(proxy, output.heartbeat(proxy))
        self._repairs.set_timer(self._wire.clock())

    def note_received(self, reader: bytes, number: int) -> None:
        """Note that a reader has a sample, and so all earlier ones, although it sent no ACKNACK.

        The reader is then not asked to acknowledge these samples. The samples are dropped at the next
        HEARTBEAT, or when the writer may soon be full, so this method costs next to nothing. May be called on
        any thread.
        """
        proxy = self.readers.get(reader)
        if proxy is None or not proxy.has_answered or number <= proxy.received:
            return
        proxy.received = number
        history = self.history
        # `received` is set before the history is checked; `add` checks in the opposite order.
        if len(history.changes) >= MOST_UNACKNOWLEDGED // 2 or history.size >= MOST_UNACKNOWLEDGED_SIZE // 2:
            self._wire.run(partial(self._repairs.take_received, proxy), None)

    def tell_again(self, reader: bytes) -> None:
        """Tell a reader again, by HEARTBEAT, which samples exist. Called inside `Wire.run`."""
        proxy = self.readers.get(reader)
        if proxy is not None:
            self._output.send_to(proxy, self._output.heartbeat(proxy))

    def unmatch(self, guid: bytes) -> None:
        """Forget a reader. Called inside `Wire.run`."""
        proxy = self.readers.pop(guid, None)
        if proxy is not None:
            self._repairs.forget_addressed(proxy, self.last)
            self._output.note_readers()
            self._repairs.note_acked()
            self._wire.tell(self.listener.on_unmatched, proxy.data)

    def move(self, reader: bytes, address: Address) -> None:
        """Send the reader's samples to another address from now on. Called inside `Wire.run`."""
        proxy = self.readers.get(reader)
        if proxy is not None:
            proxy.address = address
            self._output.note_readers()

    def linger(self, end: Callable[[], None]) -> None:
        """Call `end` once the readers have all samples, at most after `LINGER_S`. Called inside `Wire.run`.

        The listener hears of nothing any more. A second call does nothing.
        """
        if self._lingering is not None:
            return
        if is_delivered(self._output):
            end()
            return
        self.listener = WriterListener()
        self._unwatch()
        self._lingering = Lingering(self._wire, self._output, end)
        self.ask_now()

    def stop(self) -> None:
        """Stop sending. Called inside `Wire.run`."""
        self._repairs.stop()
        self._windows.stop()
        self._unwatch()
        if self._lingering is not None:
            self._lingering.stop()
        self.readers.clear()
        self._output.note_readers()

    def _unwatch(self) -> None:
        for watch in (self._deadline, self._lease):
            if watch is not None:
                watch.stop()
