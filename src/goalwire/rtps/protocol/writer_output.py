"""Writes a writer's packets: fresh samples, and HEARTBEAT and GAP, which tell readers which samples exist.

A fresh sample goes to all readers in one packet for each address. A sample may be for only one reader
(`Change.reader`). After the first such sample each reader gets separate packets. A GAP before a reader's next
sample tells it which samples are not for it.
"""

from __future__ import annotations

import struct
from collections import deque
from collections.abc import Iterable

from goalwire.rtps.protocol.announcements import EndpointData
from goalwire.rtps.protocol.fragments import FragmentSizes
from goalwire.rtps.protocol.history import Change, HistoryCache
from goalwire.rtps.protocol.messages import (
    DATA,
    INFO_TS,
    INLINE_QOS,
    LITTLE,
    WITH_DATA,
    WITH_KEY,
    Gap,
    Heartbeat,
)
from goalwire.rtps.protocol.primitives import NS, UNKNOWN_ENTITY, Address, NumberSet
from goalwire.rtps.protocol.reader_proxy import ReaderProxy
from goalwire.rtps.protocol.wire import Wire

SAMPLES_A_HEARTBEAT = 32
"""After so many samples all readers are asked at once which samples they lack."""
SAMPLES_A_QUESTION = 256
"""After so many samples that were sent to one reader alone, that reader is asked at once."""

_HEADS = struct.Struct('<BBHIIBBHHH4s4siI')
"""INFO_TS, and DATA up to its inline QoS or payload, as one struct."""


class WriterOutput:
    """Sends a writer's samples to its readers. Methods are called inside `Wire.run`."""

    def __init__(self, wire: Wire, data: EndpointData, history: HistoryCache, sizes: FragmentSizes) -> None:
        """Make the output of one writer, whose fragments have the `sizes`."""
        self.wire = wire
        self.entity_id = data.entity_id
        self.history = history
        self.fragment_size = sizes.near
        self._sizes = sizes
        self._has_far = self._has_lost = False
        """True once there was a reader on another host; True once a reader has lost fragments."""
        self.last = 0
        """The number of the last sample."""
        self.unsent: deque[Change] = deque()
        """Samples that wait for earlier ones; the first is being sent, in fragments."""
        self.readers: dict[bytes, ReaderProxy] = {}
        self.reliable: list[ReaderProxy] = []
        self.addresses: tuple[Address, ...] = ()
        """The addresses of the readers, without duplicates."""
        self.is_addressed = False
        """True once a sample was for only one reader: from then on each reader gets separate packets."""
        self.counter = 0
        """The counts of the last HEARTBEAT and HEARTBEAT_FRAG."""
        self.asked = 0
        """The number of the last sample at the last HEARTBEAT."""

    def note_far(self) -> None:
        """Note that a reader is on another host."""
        if not self._has_far:
            self._has_far = True
            self.fragment_size = self._sizes.far

    def note_loss(self) -> None:
        """Note that a reader lacks fragments that were sent; fragments to other hosts become small again."""
        self._has_lost = True
        if self._has_far:
            self.fragment_size = self._sizes.far

    def trust(self) -> None:
        """Note that many fragments have arrived without a loss: fragments to other hosts may be larger."""
        if self._has_far and not self._has_lost:
            self.fragment_size = self._sizes.most_far

    def begin_addressing(self) -> None:
        """Send each reader separate packets from now on."""
        self.is_addressed = True
        for proxy in self.readers.values():
            proxy.last = max(self.last, proxy.start - 1)

    def note_readers(self) -> None:
        """Note that a reader has been added or removed."""
        self.reliable = [proxy for proxy in self.readers.values() if proxy.is_reliable]
        self.addresses = tuple({proxy.address: None for proxy in self.readers.values()})

    # ---- samples

    def send_fresh(self, change: Change) -> None:
        """Send a sample that fits into one packet to all readers that it is for."""
        if self.is_addressed:
            if change.reader is None:
                for proxy in self.readers.values():
                    self._send_addressed(proxy, change)
            elif change.reader in self.readers:
                self._send_addressed(self.readers[change.reader], change)
            return
        packet = self._encode(self.wire.head, change, UNKNOWN_ENTITY)
        asks = self.last - self.asked >= SAMPLES_A_HEARTBEAT
        if len(self.readers) == 1:
            for proxy in self.reliable:
                if asks or not proxy.has_answered:
                    packet += self.heartbeat(proxy)
            address = self.addresses[0]
            if address[1]:  # hot path: the body of `Wire.send`, which saves a call
                self.wire.send_packet(packet, address)
            else:
                self.wire.send(packet, address)
            return
        for address in self.addresses:
            self.wire.send(packet, address)
        for proxy in self.reliable:
            if asks or not proxy.has_answered:
                self.send_to(proxy, self.heartbeat(proxy))

    def _encode(self, before: bytes, change: Change, reader: bytes) -> bytes:
        """Return a packet: its beginning `before`, INFO_TS and DATA for the entity id `reader`."""
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
        heads = _HEADS.pack(
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
            reader,
            self.entity_id,
            number >> 32,
            number & 0xFFFFFFFF,
        )
        return b'%b%b%b%b%b' % (before, heads, qos, payload, b'\0\0\0'[:pad])

    def _send_addressed(self, proxy: ReaderProxy, change: Change) -> None:
        """Send a sample to one reader, after a GAP for skipped samples that were for other readers."""
        before = self.wire.head + proxy.asks
        if proxy.last + 1 < change.number:
            before += self.gap_before(proxy, change.number)
        proxy.last = change.number
        packet = self._encode(before, change, proxy.entity_id)
        asks = len(proxy.addressed) % SAMPLES_A_QUESTION == SAMPLES_A_QUESTION - 1
        if proxy.is_reliable and (asks or not proxy.has_answered):
            packet += self.heartbeat(proxy)
        self.wire.send(packet, proxy.address)

    def gap_before(self, proxy: ReaderProxy, number: int) -> bytes:
        """Return GAP for the samples between the last sample sent to a reader and `number`."""
        first = max(proxy.last + 1, proxy.start)
        if not self.is_addressed or first >= number or not proxy.is_reliable:
            return b''
        return Gap(proxy.entity_id, self.entity_id, first, NumberSet(number)).encode()

    def whole(self, proxy: ReaderProxy, change: Change) -> bytes:
        """Return INFO_TS and DATA with a whole sample, addressed to one reader."""
        return self._encode(b'', change, proxy.entity_id)

    def send_to(self, proxy: ReaderProxy, submessages: bytes) -> None:
        """Send a packet to one reader."""
        self.wire.send(self.wire.head + proxy.asks + submessages, proxy.address)

    def receivers(self, change: Change) -> Iterable[ReaderProxy]:
        """Return the readers that get a sample."""
        if change.reader is None:
            return self.readers.values()
        proxy = self.readers.get(change.reader)
        return () if proxy is None else (proxy,)

    # ---- the samples that each reader has been sent

    def find_last_sent(self) -> int:
        """Return the number of the last sample that has been sent completely."""
        return self.unsent[0].number - 1 if self.unsent else self.last

    def last_for(self, proxy: ReaderProxy) -> int:
        """Return the number of the last sample that a reader has been sent, or that was for other readers."""
        return proxy.last if self.is_addressed else max(self.find_last_sent(), proxy.start - 1)

    def heartbeat(self, proxy: ReaderProxy, *, is_final: bool = False, asserts: bool = False) -> bytes:
        """Return HEARTBEAT for one reader, after a GAP for samples that were for other readers."""
        self.counter += 1
        last = self.last_for(proxy)
        self.asked = self.last
        first = min(max(self.history.first(self.last), proxy.start), last + 1)
        gap = b''
        if self.is_addressed and proxy.acked + 1 < first:
            gap = Gap(proxy.entity_id, self.entity_id, proxy.acked + 1, NumberSet(first)).encode()
        told = Heartbeat(proxy.entity_id, self.entity_id, first, last, self.counter, is_final, asserts)
        return gap + told.encode()

    def is_open(self, proxy: ReaderProxy) -> bool:
        """Return True if a reader has still to acknowledge samples, or has never answered."""
        return not proxy.has_answered or proxy.acked < self.last_for(proxy)

    def has_all(self, proxy: ReaderProxy) -> bool:
        """Return True if a reader is known to have all its samples. May be called on any thread."""
        return max(proxy.acked, proxy.received) >= self.last_for(proxy)
