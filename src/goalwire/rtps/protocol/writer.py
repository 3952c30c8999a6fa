"""A writer: what it sends to each of its readers, and sends again.

A fresh sample goes to all readers at once, in one packet for each address. It is kept for those that may ask
for it again: reliable readers that have not acknowledged it, and readers that come later (transient local).

A reliable reader is asked by HEARTBEAT what it lacks. It answers by ACKNACK, and gets what it lacks at once.
A reader that has answered before is asked some time after a sample, so that a stream costs few answers; one
that has not may not know this writer yet, and is asked with each sample. One that does not answer is asked
ever more rarely, and nobody waits for it but a writer that keeps all.

A sample that fits no packet is sent in fragments, a window at a time, for the sake of sockets' buffers. The
next window goes out when a reader asks for it, or after a moment.

A sample may be meant for one reader alone (`to`). Others learn by GAP, in front of what they get next, that
it is none of theirs.
"""

from __future__ import annotations

import struct
from collections import deque
from collections.abc import Iterable
from functools import partial

from goalwire.rtps.protocol.announcements import EndpointData
from goalwire.rtps.protocol.fragments import cut, fragment_count
from goalwire.rtps.protocol.history import Change, HistoryCache
from goalwire.rtps.protocol.messages import (
    DATA,
    INFO_TS,
    INLINE_QOS,
    LITTLE,
    WITH_DATA,
    WITH_KEY,
    AckNack,
    Gap,
    Heartbeat,
    HeartbeatFrag,
    NackFrag,
    info_dst,
    info_ts,
)
from goalwire.rtps.protocol.primitives import (
    INFINITE,
    NS,
    UNKNOWN_ENTITY,
    Address,
    NumberSet,
    encode_time,
)
from goalwire.rtps.protocol.qos import MANUAL_BY_TOPIC, RELIABLE, TRANSIENT_LOCAL
from goalwire.rtps.protocol.wire import FOREVER, Timer, Watch, Wire

FIRST_HEARTBEAT_S = 0.005
"""How long after a match an unanswered HEARTBEAT is sent again."""
HEARTBEAT_S = 0.010
"""How long after a sample its readers are asked whether they have it."""
RAREST_HEARTBEAT_S = 1.0
"""How long a reader that does not answer is left alone at most."""
SAMPLES_A_HEARTBEAT = 32
"""Samples after which readers are asked at once."""
WINDOW, WINDOW_PACKETS = 120_000, 11
"""Bytes, and fragments, that are sent before somebody asks for more, or WINDOW_S is over. A socket's default
buffer on Linux takes three packets of 60,000 bytes, or twelve of 8,000."""
WINDOW_S = 0.0005
LARGEST_WINDOW = 1 << 20
"""Bytes of a window to readers that have taken smaller ones without a loss, each time twice as many."""
MOST_UNACKNOWLEDGED = 1024
MOST_UNACKNOWLEDGED_SIZE = 16 << 20
"""Samples, and bytes, that a writer keeps for its readers before it is full, where it keeps all."""
NEAR_FRAGMENT, FAR_FRAGMENT = 60_000, 8_000
"""Bytes of a fragment to readers on this host, and on others."""
_PACKET_ROOM = 400
"""Bytes that stand in a packet beside the payload."""

_FRESH = struct.Struct('<20sBBHIIBBHHH4s4siI')
"""Header, INFO_TS and the head of DATA, in one go: the beginning of most packets."""


def is_newer(counter: int, before: int) -> bool:
    """Whether a count follows another; counts have 32 bits and begin again."""
    return 0 < (counter - before) & 0xFFFFFFFF < 0x80000000


def _fragments_of(window: int, change: Change) -> int:
    """Return how many fragments of a sample a window of so many bytes has."""
    return max(1, min(window // change.fragment_size, WINDOW_PACKETS * window // WINDOW))


class WriterListener:
    """Is told what happens to a writer. Every method is called without any lock."""

    def on_matched(self, reader: EndpointData) -> None:
        """A reader gets what is written from now on."""

    def on_unmatched(self, reader: EndpointData) -> None:
        """A reader has gone."""

    def on_incompatible(self, reader: EndpointData, policy: str) -> None:
        """A reader of the topic asks for more than the writer offers, by this policy."""

    def on_room(self) -> None:
        """A writer that was full has room again."""

    def on_deadline_missed(self) -> None:
        """Nothing was written for the time that the deadline allows."""

    def on_liveliness_lost(self) -> None:
        """Nothing was written or asserted for the time of the lease; readers hold the writer for dead."""


class ReaderProxy:
    """One reader, as its writer knows it."""

    __slots__ = (
        'acked',
        'address',
        'asks',
        'counter',
        'data',
        'due',
        'entity_id',
        'frag_counter',
        'has_answered',
        'interval',
        'is_reliable',
        'last',
        'start',
    )

    def __init__(self, data: EndpointData, address: Address, is_reliable: bool, start: int) -> None:
        self.data = data
        self.address = address
        self.entity_id = data.entity_id
        self.asks = info_dst(data.prefix)
        """INFO_DST of its participant."""
        self.is_reliable = is_reliable
        self.start = start
        """The first sample that it is to have."""
        self.acked = start - 1
        """All samples up to this one are acknowledged, or none of its business."""
        self.last = start - 1
        """The last sample that it has been sent, where samples are addressed."""
        self.counter = self.frag_counter = 0
        """Of its last ACKNACK and NACK_FRAG."""
        self.has_answered = False
        self.interval = FIRST_HEARTBEAT_S
        self.due = FOREVER
        """When it is asked next."""


class Writer:
    """A writer of one topic. Methods without underscore may be called on any thread."""

    def __init__(
        self,
        wire: Wire,
        data: EndpointData,
        listener: WriterListener,
        *,
        is_keyed: bool = False,
        fragment_size: int = NEAR_FRAGMENT,
    ) -> None:
        """`is_keyed` is for built-in writers; `fragment_size` holds as long as all readers are near."""
        self.data = data
        self.listener = listener
        self.entity_id = data.entity_id
        self.last = 0
        """The number of the last sample."""
        self.readers: dict[bytes, ReaderProxy] = {}
        self.history = HistoryCache(data.qos.depth, is_keyed=is_keyed)
        self._wire = wire
        self._is_local_history = data.qos.durability >= TRANSIENT_LOCAL
        self._is_reliable = data.qos.reliability == RELIABLE
        self._reliable: list[ReaderProxy] = []
        self._addresses: tuple[Address, ...] = ()
        self._fragment_size = fragment_size
        self._is_addressed = False
        """Whether a sample was meant for one reader alone: then each reader gets packets of its own."""
        self._acked = 0
        """All samples up to this one are acknowledged by all reliable readers."""
        self._was_full = False
        self._counter = 0
        self._asked = 0
        """The last sample when readers were asked last."""
        self._timer: Timer | None = None
        self._unsent: deque[Change] = deque()
        self._unsent_size = 0
        self._next_fragment = 1
        self._window, self._largest_window = WINDOW, LARGEST_WINDOW
        self._window_timer: Timer | None = None
        self._deadline = self._lease = None
        if data.qos.deadline < INFINITE:
            self._deadline = Watch(
                wire, data.qos.deadline / NS, partial(wire.tell, listener.on_deadline_missed)
            )
        if data.qos.liveliness == MANUAL_BY_TOPIC and data.qos.lease < INFINITE:
            self._lease = Watch(wire, data.qos.lease / NS, partial(wire.tell, listener.on_liveliness_lost))

    # ---- writing

    def write(
        self, payload: bytes, *, qos: bytes = b'', to: bytes | None = None, time_ns: int | None = None
    ) -> int | None:
        """Send a sample and return its number; None if the writer is full, which `on_room` ends.

        `qos` is inline QoS, `to` the GUID of the only reader to get it. A signal's handler that interrupts
        its own thread in here gets 0: its sample is sent right after that.
        """
        otherwise: int | None = 0
        return self._wire.run(partial(self.add, payload, qos, to, time_ns), otherwise)

    def is_full(self) -> bool:
        """Whether a writer that keeps all waits for its readers."""
        if self.data.qos.depth:
            return False
        if self._unsent_size >= MOST_UNACKNOWLEDGED_SIZE:
            return True
        is_behind = self.last - self._acked >= MOST_UNACKNOWLEDGED
        return bool(self._reliable) and (is_behind or self._unacked_size() >= MOST_UNACKNOWLEDGED_SIZE)

    def is_acknowledged(self) -> bool:
        """Whether readers that have ever answered have acknowledged all that was written for them."""
        return not any(proxy.has_answered and self._is_open(proxy) for proxy in tuple(self._reliable))

    def _unacked_size(self) -> int:
        if not self._is_local_history:
            return self.history.size
        changes, acked = self.history.changes, self._acked
        return sum(changes[number].size for number in range(acked + 1, self.last + 1) if number in changes)

    def add(
        self,
        payload: bytes | None,
        qos: bytes = b'',
        to: bytes | None = None,
        time_ns: int | None = None,
        key: bytes = b'',
        is_key: bool = False,
    ) -> int | None:
        """Do what `write` says. Inside `Wire.run`."""
        if not self.data.qos.depth and self.is_full():
            self._was_full = True
            return None
        wire = self._wire
        number = self.last + 1
        change = Change(number, time_ns or wire.wall_clock_ns(), payload, qos, to, key, is_key)
        if to is not None and not self._is_addressed:
            self._is_addressed = True
            for proxy in self.readers.values():
                proxy.last = max(self.last, proxy.start - 1)
        self.last = number
        self._note_alive()
        if self._reliable or self._is_local_history:
            if self.data.qos.lifespan < INFINITE:
                self.history.expire(change.time - self.data.qos.lifespan)
            self.history.add(change)
        else:
            self._acked = number
        if not self.readers:
            return number
        if self._unsent or (payload is not None and len(payload) > self._fragment_size):
            self._queue(change)
        else:
            self._send_fresh(change)
            if self._timer is None and self._reliable:
                self._expect_answers()
        return number

    def assert_liveliness(self) -> None:
        """Say that the writer lives, to readers that mind."""
        self._wire.run(self._assert, None)

    def _assert(self) -> None:
        self._note_alive()
        for proxy in self.readers.values():
            self._send_to(proxy, self._heartbeat(proxy, is_final=True, asserts=True))

    def _note_alive(self) -> None:
        if self._deadline is not None:
            self._deadline.heard = self._wire.clock()
        if self._lease is not None:
            self._lease.heard = self._wire.clock()

    def _send_fresh(self, change: Change) -> None:
        """Send a sample that fits a packet to all that it is for."""
        if self._is_addressed:
            for proxy in self._receivers(change):
                self._send_addressed(proxy, change)
            return
        packet = self._encode(change)
        asks = self.last - self._asked >= SAMPLES_A_HEARTBEAT
        if len(self.readers) == 1:
            for proxy in self._reliable:
                if asks or not proxy.has_answered:
                    packet += self._heartbeat(proxy)
            self._wire.send(packet, self._addresses[0])
            return
        for address in self._addresses:
            self._wire.send(packet, address)
        for proxy in self._reliable:
            if asks or not proxy.has_answered:
                self._send_to(proxy, self._heartbeat(proxy))

    def _encode(self, change: Change) -> bytes:
        """Return a packet with a whole sample, for all readers."""
        payload, number, qos = change.payload, change.number, change.qos
        seconds, rest = divmod(change.time, NS)
        flags = LITTLE
        if payload is None:
            payload = b''
        else:
            flags |= WITH_KEY if change.is_key else WITH_DATA
        if qos:
            flags |= INLINE_QOS
        size = 20 + len(qos) + len(payload)
        pad = -size & 3
        head = _FRESH.pack(
            self._wire.head,
            INFO_TS,
            LITTLE,
            8,
            seconds & 0xFFFFFFFF,
            ((rest << 32) + 999_999_999) // NS,
            DATA,
            flags,
            size + pad,
            0,
            16,
            UNKNOWN_ENTITY,
            self.entity_id,
            number >> 32,
            number & 0xFFFFFFFF,
        )
        return b'%b%b%b%b' % (head, qos, payload, b'\0\0\0'[:pad])

    def _send_addressed(self, proxy: ReaderProxy, change: Change) -> None:
        """Send a sample to one reader, behind a GAP for those that were others'."""
        gap = self._gap_before(proxy, change.number)
        proxy.last = change.number
        heartbeat = b''
        if proxy.is_reliable and not proxy.has_answered:
            heartbeat = self._heartbeat(proxy)
        self._send_to(proxy, gap + self._whole(proxy, change) + heartbeat)

    def _gap_before(self, proxy: ReaderProxy, number: int) -> bytes:
        """Return GAP for the samples between the last that a reader was sent and `number`."""
        first = max(proxy.last + 1, proxy.start)
        if not self._is_addressed or first >= number or not proxy.is_reliable:
            return b''
        return Gap(proxy.entity_id, self.entity_id, first, NumberSet(number)).encode()

    def _whole(self, proxy: ReaderProxy, change: Change) -> bytes:
        """Return INFO_TS and DATA for one reader."""
        data = self._encode(change)[20:]
        return data[:20] + proxy.entity_id + data[24:]

    def _send_to(self, proxy: ReaderProxy, submessages: bytes) -> None:
        self._wire.send(self._wire.head + proxy.asks + submessages, proxy.address)

    def _receivers(self, change: Change) -> Iterable[ReaderProxy]:
        if change.reader is None:
            return self.readers.values()
        proxy = self.readers.get(change.reader)
        return () if proxy is None else (proxy,)

    # ---- samples in fragments

    def _queue(self, change: Change) -> None:
        """Have a sample sent in its turn, behind those that are being sent."""
        if change.size > self._fragment_size:
            change.fragment_size = self._fragment_size
        depth = self.data.qos.depth
        if depth and len(self._unsent) > depth:  # the first is being sent
            self._unsent_size -= self._unsent[1].size
            del self._unsent[1]
        self._unsent.append(change)
        self._unsent_size += change.size
        if self._window_timer is None or self._window_timer.when <= self._wire.clock():
            self._send_window()

    def _send_window(self) -> None:
        """Send what waits, up to a window."""
        if self._window_timer is not None:
            self._window_timer.cancel()
            self._window_timer = None
        left = self._window
        while self._unsent and left > 0:
            change = self._unsent[0]
            if not change.fragment_size:
                self._take_unsent()
                left -= change.size
                self._send_fresh(change)
                continue
            left -= self._send_fragments(change)
            if self._next_fragment <= fragment_count(change.size, change.fragment_size):
                self._tell_fragments(change)
                break
            self._take_unsent()
            for proxy in self._receivers(change):
                proxy.last = change.number
                if proxy.is_reliable:
                    self._send_to(proxy, self._heartbeat(proxy))
        if self._unsent:
            self._window_timer = self._wire.timers.at(self._wire.clock() + WINDOW_S, self._send_window)
        elif self._was_full:
            self._offer_room()
        if self._timer is None and self._reliable:
            self._expect_answers()

    def _take_unsent(self) -> None:
        """Count the first of those that wait as sent."""
        self._unsent_size -= self._unsent.popleft().size
        self._next_fragment = 1

    def _send_fragments(self, change: Change) -> int:
        """Send the next fragments of a sample, up to a window; return how many bytes."""
        first = self._next_fragment
        end = min(
            first + _fragments_of(self._window, change), fragment_count(change.size, change.fragment_size) + 1
        )
        stamp = info_ts(encode_time(change.time))
        if self._is_addressed:
            for proxy in self._receivers(change):
                if first == 1:
                    gap = self._gap_before(proxy, change.number)
                    if gap:
                        self._send_to(proxy, gap)
                before = self._wire.head + proxy.asks + stamp
                for fragment in range(first, end):
                    packet = cut(before, change, proxy.entity_id, self.entity_id, fragment)
                    self._wire.send(packet, proxy.address)
        else:
            before = self._wire.head + stamp
            for fragment in range(first, end):
                packet = cut(before, change, UNKNOWN_ENTITY, self.entity_id, fragment)
                for address in self._addresses:
                    self._wire.send(packet, address)
        self._next_fragment = end
        return (end - first) * change.fragment_size

    def _tell_fragments(self, change: Change) -> None:
        """Tell reliable readers how many fragments there are: who lacks the next ones asks for them."""
        count = fragment_count(change.size, change.fragment_size)
        for proxy in self._receivers(change):
            if proxy.is_reliable:
                self._counter += 1
                told = HeartbeatFrag(proxy.entity_id, self.entity_id, change.number, count, self._counter)
                self._send_to(proxy, told.encode())

    def on_nack_frag(self, proxy: ReaderProxy, nack: NackFrag) -> None:
        """Send the fragments that a reader asks for, up to a window. Inside `Wire.run`."""
        if not is_newer(nack.counter, proxy.frag_counter):
            return
        proxy.frag_counter = nack.counter
        proxy.interval = HEARTBEAT_S
        missing = nack.missing.numbers()
        begun = self._unsent[0] if self._unsent else None
        if begun is not None and begun.number == nack.number:
            sent = self._next_fragment
            if missing and missing[0] >= sent:
                self._window = min(2 * self._window, self._largest_window)
            if missing and missing[-1] >= sent:
                self._send_window()
            missing = [fragment for fragment in missing if fragment < sent]
        change = self.history.changes.get(nack.number)
        if change is not None and change.fragment_size and missing:
            self._window = self._largest_window = max(WINDOW, self._window // 2)
            self._send_some(proxy, change, missing)
            self._send_to(proxy, self._heartbeat(proxy))

    def _send_some(self, proxy: ReaderProxy, change: Change, fragments: Iterable[int]) -> None:
        """Send some fragments of a sample to one reader, up to a window."""
        count = fragment_count(change.size, change.fragment_size)
        before = self._wire.head + proxy.asks + info_ts(encode_time(change.time))
        for fragment in list(fragments)[: _fragments_of(WINDOW, change)]:
            if 0 < fragment <= count:
                packet = cut(before, change, proxy.entity_id, self.entity_id, fragment)
                self._wire.send(packet, proxy.address)

    # ---- what readers have, and lack

    def _sent(self) -> int:
        """Return the last sample that has been sent as a whole."""
        return self._unsent[0].number - 1 if self._unsent else self.last

    def _last_for(self, proxy: ReaderProxy) -> int:
        """Return the last sample that a reader has been sent, or that was none of its business."""
        return proxy.last if self._is_addressed else max(self._sent(), proxy.start - 1)

    def _heartbeat(self, proxy: ReaderProxy, *, is_final: bool = False, asserts: bool = False) -> bytes:
        """Return HEARTBEAT for one reader, behind a GAP for samples that were others'."""
        self._counter += 1
        last = self._last_for(proxy)
        self._asked = self.last
        first = min(max(self.history.first(self.last), proxy.start), last + 1)
        gap = b''
        if self._is_addressed and proxy.acked + 1 < first:
            gap = Gap(proxy.entity_id, self.entity_id, proxy.acked + 1, NumberSet(first)).encode()
        told = Heartbeat(proxy.entity_id, self.entity_id, first, last, self._counter, is_final, asserts)
        return gap + told.encode()

    def _is_open(self, proxy: ReaderProxy) -> bool:
        """Whether a reader has something to acknowledge, or has never answered."""
        return not proxy.has_answered or proxy.acked < self._last_for(proxy)

    def _expect_answers(self) -> None:
        """Ask reliable readers some time from now, if they have not acknowledged all by then."""
        now = self._wire.clock()
        for proxy in self._reliable:
            if proxy.due == FOREVER and self._is_open(proxy):
                proxy.due = now + proxy.interval
        self._set_timer(now)

    def _set_timer(self, now: float) -> None:
        due = min((proxy.due for proxy in self._reliable), default=FOREVER)
        if self._timer is not None:
            if self._timer.when <= due:
                return
            self._timer.cancel()
            self._timer = None
        if due < FOREVER:
            self._timer = self._wire.timers.at(max(due, now), self._ask)

    def _ask(self) -> None:
        """Send HEARTBEAT to the readers whose time has come."""
        self._timer = None
        now = self._wire.clock()
        for proxy in self._reliable:
            if not self._is_open(proxy):
                proxy.due = FOREVER
            elif proxy.due <= now:
                self._send_to(proxy, self._heartbeat(proxy))
                proxy.interval = min(2 * proxy.interval, RAREST_HEARTBEAT_S)
                proxy.due = now + proxy.interval
            elif proxy.due == FOREVER:
                proxy.due = now + proxy.interval
        self._set_timer(now)

    def on_acknack(self, proxy: ReaderProxy, acknack: AckNack) -> None:
        """Take note of what a reader has, and send what it lacks. Inside `Wire.run`."""
        base, missing = acknack.missing.base, acknack.missing.numbers()
        has_nothing = base <= max(1, proxy.start) and not missing and not acknack.is_final
        if not proxy.is_reliable or not (has_nothing or is_newer(acknack.counter, proxy.counter)):
            return
        proxy.counter = acknack.counter
        proxy.has_answered = True
        last = self._last_for(proxy)
        acked = min(base - 1, last)
        if acked > proxy.acked:
            proxy.acked = acked
            proxy.interval = HEARTBEAT_S
            proxy.due = FOREVER
            self._note_acked()
        if missing:
            proxy.interval = HEARTBEAT_S
            self._repair(proxy, missing)
        elif has_nothing and proxy.acked < last:  # it will ask for all of it
            self._repair(proxy, list(range(proxy.acked + 1, min(last, proxy.acked + 256) + 1)))
        elif not acknack.is_final:
            self._send_to(proxy, self._heartbeat(proxy))
        if self._is_open(proxy):
            self._expect_answers()

    def _note_acked(self) -> None:
        """Let go of samples that all reliable readers have."""
        sent = self._sent()
        self._acked = min(
            (proxy.acked if self._is_open(proxy) else sent for proxy in self._reliable), default=sent
        )
        if not self._is_local_history:
            self.history.remove_up_to(self._acked)
        if self._wire.on_acknowledged is not None:
            self._wire.tell(self._wire.on_acknowledged)
        if self._was_full:
            self._offer_room()

    def _offer_room(self) -> None:
        if not self.is_full():
            self._was_full = False
            self._wire.tell(self.listener.on_room)

    def _repair(self, proxy: ReaderProxy, numbers: list[int]) -> None:
        """Send samples again to one reader, up to a window, and ask it what it lacks then."""
        if self.data.qos.lifespan < INFINITE:
            self.history.expire(self._wire.wall_clock_ns() - self.data.qos.lifespan)
        last = self._last_for(proxy)
        gone: list[int] = []
        parts: list[bytes] = []
        size, left = 0, WINDOW
        for number in numbers:
            change = self.history.changes.get(number)
            if number > last or left <= 0:
                break
            if change is None or number < proxy.start or change.reader not in (None, proxy.data.guid):
                gone.append(number)
            elif change.fragment_size:
                self._send_some(proxy, change, range(1, 257))
                left -= min(WINDOW, change.size)
            else:
                part = self._whole(proxy, change)
                if size + len(part) > self._fragment_size:
                    self._send_to(proxy, b''.join(parts))
                    parts, size = [], 0
                parts.append(part)
                size += len(part)
                left -= len(part)
        if gone:
            parts.insert(0, self._gap(proxy, gone))
        parts.append(self._heartbeat(proxy))
        self._send_to(proxy, b''.join(parts))

    def _gap(self, proxy: ReaderProxy, numbers: list[int]) -> bytes:
        """Return GAP for numbers in order, less than 256 apart."""
        base = numbers[0] + 1
        while base - numbers[0] < len(numbers) and numbers[base - numbers[0]] == base:
            base += 1
        rest = [number for number in numbers if number >= base]
        return Gap(proxy.entity_id, self.entity_id, numbers[0], NumberSet.of(base, rest)).encode()

    # ---- readers that come and go

    def match(self, reader: EndpointData, address: Address, *, is_near: bool, pushes: bool = False) -> None:
        """Take up a reader; `pushes`: send it all at once, unasked. Inside `Wire.run`."""
        is_reliable = self._is_reliable and reader.qos.reliability == RELIABLE
        wants_history = self._is_local_history and reader.qos.durability >= TRANSIENT_LOCAL
        if wants_history and self.data.qos.lifespan < INFINITE:
            self.history.expire(self._wire.wall_clock_ns() - self.data.qos.lifespan)
        start = self.history.first(self.last) if wants_history else self.last + 1
        proxy = ReaderProxy(reader, address, is_reliable, start)
        if self._is_addressed or wants_history:
            proxy.last = self.last
        self.readers[reader.guid] = proxy
        if not is_near:
            self._fragment_size = min(self._fragment_size, FAR_FRAGMENT)
        self._note_readers()
        self._wire.tell(self.listener.on_matched, reader)
        if not is_reliable:
            return
        proxy.due = self._wire.clock() + proxy.interval
        if pushes and start <= self.last:
            self._repair(proxy, list(self.history.changes))
        else:
            self._send_to(proxy, self._heartbeat(proxy))
        self._set_timer(self._wire.clock())

    def unmatch(self, guid: bytes) -> None:
        """Forget a reader. Inside `Wire.run`."""
        proxy = self.readers.pop(guid, None)
        if proxy is not None:
            self._note_readers()
            self._note_acked()
            self._wire.tell(self.listener.on_unmatched, proxy.data)

    def _note_readers(self) -> None:
        self._reliable = [proxy for proxy in self.readers.values() if proxy.is_reliable]
        self._addresses = tuple({proxy.address: None for proxy in self.readers.values()})

    def stop(self) -> None:
        """Send nothing more. Inside `Wire.run`."""
        for each in (self._timer, self._window_timer):
            if each is not None:
                each.cancel()
        for watch in (self._deadline, self._lease):
            if watch is not None:
                watch.stop()
        self._unsent.clear()
        self.readers.clear()
        self._note_readers()
