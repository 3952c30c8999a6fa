"""A reader: puts what its writers send in order, and asks for what is missing.

A reliable reader delivers the samples of each writer in the order of their numbers. What comes too early is
held back; what is missing is asked for by ACKNACK as soon as HEARTBEAT tells of it, a moment after a gap has
shown itself, and again if it does not come. A best-effort reader delivers what comes, and skips what is late.

A reader does not know with which number a writer begins for it, so it asks at its match (the *preemptive*
ACKNACK), and holds back what comes until the writer's first HEARTBEAT has told.
"""

from __future__ import annotations

from functools import partial

from goalwire.rtps.protocol import bounds
from goalwire.rtps.protocol.announcements import EndpointData
from goalwire.rtps.protocol.backlog import Backlog, Sample
from goalwire.rtps.protocol.messages import (
    AckNack,
    Data,
    DataFrag,
    Gap,
    Heartbeat,
    HeartbeatFrag,
    NackFrag,
    info_dst,
)
from goalwire.rtps.protocol.primitives import INFINITE, NS, Address, NumberSet, is_keyed, is_newer
from goalwire.rtps.protocol.qos import RELIABLE, TRANSIENT_LOCAL
from goalwire.rtps.protocol.wire import Timer, Watch, Wire

__all__ = ['Reader', 'ReaderListener', 'Sample', 'WriterProxy']

FIRST_ASK_S = 0.005
"""How long after a match a writer is asked again for its first HEARTBEAT."""
GAP_S = 0.002
"""How long a sample may be late that others have overtaken, before it is asked for."""
ASK_AGAIN_S = 0.020
"""How long what was asked for may take, before it is asked for again; the time doubles each time."""
ON_THE_WAY_S = 0.002
"""How long what was asked for may take, before a HEARTBEAT has it asked for again. Without that, two sides
that disagree about what there is would ask and answer each other without a pause."""
RAREST_ASK_S = 0.5
RAREST_FIRST_ASK_S = 1.0
_MOST_PARTIALS_ASKED = 4
"""Samples whose fragments are asked for at a time."""


class ReaderListener:
    """Is told what happens to a reader. Every method is called without any lock."""

    def on_sample(self, sample: Sample) -> None:
        """A sample has come, in its turn."""

    def on_matched(self, writer: EndpointData) -> None:
        """What a writer writes comes from now on."""

    def on_answered(self, writer: EndpointData) -> None:
        """A reliable writer has told what it has, for the first time: it knows the reader."""

    def on_unmatched(self, writer: EndpointData) -> None:
        """A writer has gone."""

    def on_incompatible(self, writer: EndpointData, policy: str) -> None:
        """A writer of the topic offers less than the reader asks for, by this policy."""

    def on_lost(self, count: int) -> None:
        """Samples will not come any more."""

    def on_deadline_missed(self) -> None:
        """Nothing came for the time that the deadline allows."""

    def on_liveliness(self, writer: bytes, is_alive: bool) -> None:
        """A writer has fallen silent for its lease, or speaks again."""


class WriterProxy:
    """One writer, as a reader knows it."""

    __slots__ = (
        'address',
        'asked',
        'asked_at',
        'asks',
        'backlog',
        'counter',
        'data',
        'entity_id',
        'frag_counter',
        'interval',
        'is_alive',
        'is_reliable',
        'known',
        'next',
        'reader',
        'sent_counter',
        'timer',
        'watch',
    )

    def __init__(
        self, wire: Wire, reader: Reader, data: EndpointData, address: Address, is_reliable: bool
    ) -> None:
        self.reader = reader
        self.data = data
        self.address = address
        self.entity_id = data.entity_id
        self.asks = info_dst(data.prefix)
        """INFO_DST of its participant."""
        self.is_reliable = is_reliable
        self.next = 0
        """The sample that is delivered next; 0 until that is known."""
        self.known = 0
        """The last sample that the writer is known to have."""
        self.backlog = Backlog(wire)
        self.counter = self.frag_counter = 0
        """Of its last HEARTBEAT and HEARTBEAT_FRAG."""
        self.sent_counter = 0
        """Of what was sent to it last."""
        self.asked, self.asked_at = 0, 0.0
        """From which sample on others were asked for last, and when."""
        self.timer: Timer | None = None
        self.interval = FIRST_ASK_S
        self.watch: Watch | None = None
        """Over its liveliness, where that has a lease."""
        self.is_alive = True


class Reader:
    """A reader of one topic. Its methods are called inside `Wire.run`, if nothing else is said."""

    def __init__(self, wire: Wire, data: EndpointData, listener: ReaderListener) -> None:
        self.data = data
        self.listener = listener
        self.entity_id = data.entity_id
        self.writers: dict[bytes, WriterProxy] = {}
        self._wire = wire
        self._is_reliable = data.qos.reliability == RELIABLE
        self._is_paused = False
        self._on_sample = listener.on_sample
        self._most_history = 0
        """How many samples of those that were written before its match it takes; 0: all that there are."""
        if data.qos.durability >= TRANSIENT_LOCAL and not is_keyed(data.entity_id):
            self._most_history = max(data.qos.depth, 0)
        self._deadline: Watch | None = None

    def start(self) -> None:
        """Watch its deadline from now on."""
        wire, deadline = self._wire, self.data.qos.deadline
        if deadline < INFINITE:
            self._deadline = Watch(wire, deadline / NS, partial(wire.tell, self.listener.on_deadline_missed))

    # ---- a user who is slow

    def pause(self) -> None:
        """Deliver nothing, and acknowledge nothing new, until `resume`. On any thread.

        A reliable writer that keeps all then waits in time. What comes meanwhile is held back within bounds.
        """
        self._wire.run(partial(setattr, self, '_is_paused', True), None)

    def resume(self) -> None:
        """Deliver again. On any thread."""
        self._wire.run(self._resume, None)

    def _resume(self) -> None:
        self._is_paused = False
        for proxy in self.writers.values():
            self._release(proxy)
            if proxy.is_reliable and proxy.next:
                self._ask(proxy)

    # ---- what writers send

    def on_data(self, proxy: WriterProxy, data: Data, time: int | None) -> None:
        """Take a sample."""
        number = data.number
        if proxy.watch is not None:
            self.note_alive(proxy)
        sample = Sample(proxy.data.guid, number, time, data.payload, data.qos, data.is_key)
        backlog = proxy.backlog
        if number == proxy.next and not self._is_paused:
            proxy.next = number + 1
            if backlog.partials:
                backlog.drop_partial(number)
            self._deliver(proxy, sample)
            if backlog.held:
                self._release(proxy)
        elif not proxy.is_reliable:
            if number >= proxy.next and not self._is_paused:
                if proxy.next and number > proxy.next:
                    self._wire.tell(self.listener.on_lost, number - proxy.next)
                proxy.next = number + 1
                if backlog.partials:
                    backlog.drop_partials(lambda key: key <= number)
                self._deliver(proxy, sample)
        elif number >= proxy.next and number not in backlog.held:
            self._hold(proxy, sample)

    def _hold(self, proxy: WriterProxy, sample: Sample) -> None:
        """Keep a sample until those before it have come; beyond the bounds it is asked for again later."""
        if not proxy.backlog.hold(sample, proxy.next):
            return
        self._release(proxy)
        if proxy.next and sample.number > proxy.next:
            proxy.known = max(proxy.known, sample.number)
            self._ask_in(proxy, GAP_S)

    def _release(self, proxy: WriterProxy) -> None:
        """Deliver what was held back and is next."""
        backlog = proxy.backlog
        if not proxy.next:
            return
        while proxy.next in backlog.held and not self._is_paused:
            sample = backlog.take(proxy.next)
            proxy.next += 1
            if sample is not None:
                self._deliver(proxy, sample)

    def _deliver(self, proxy: WriterProxy, sample: Sample) -> None:
        lifespan = proxy.data.qos.lifespan
        if lifespan < INFINITE and sample.time and sample.time + lifespan < self._wire.wall_clock_ns():
            return
        if self._deadline is not None:
            self._deadline.heard = self._wire.clock()
        self._wire.tell(self._on_sample, sample)

    def on_fragment(self, proxy: WriterProxy, fragment: DataFrag, time: int | None) -> None:
        """Take some fragments of a sample; raises RtpsError."""
        number = fragment.number
        if proxy.watch is not None:
            self.note_alive(proxy)
        if number < proxy.next or number in proxy.backlog.held or (self._is_paused and not proxy.is_reliable):
            return
        begun = proxy.backlog.add(fragment, proxy.next, is_reliable=proxy.is_reliable)
        if begun is None:
            return
        if begun.is_whole:
            proxy.backlog.drop_partial(number)
            data = Data(fragment.reader, fragment.writer, number, begun.qos, begun.join(), begun.is_key)
            self.on_data(proxy, data, time)
        elif proxy.is_reliable and proxy.next:
            proxy.known = max(proxy.known, number)
            if proxy.timer is None:
                proxy.interval = ASK_AGAIN_S
            self._ask_in(proxy, ASK_AGAIN_S)

    def on_heartbeat(self, proxy: WriterProxy, heartbeat: Heartbeat) -> None:
        """Learn which samples a writer has, and ask for those that are missing."""
        if proxy.watch is not None and heartbeat.asserts_liveliness:
            self.note_alive(proxy)
        if not proxy.is_reliable or (proxy.next and not is_newer(heartbeat.counter, proxy.counter)):
            return
        proxy.counter = heartbeat.counter
        first = heartbeat.first
        if not proxy.next:
            if self._most_history:
                first = max(first, heartbeat.last - self._most_history + 1)
            proxy.next = first
            self._stop_timer(proxy)
            proxy.backlog.drop_below(first)
            self._wire.tell(self.listener.on_answered, proxy.data)
        elif first > proxy.next:
            self._skip(proxy, first, is_loss=True)
        proxy.known = heartbeat.last
        self._release(proxy)
        if self._is_missing(proxy):
            if proxy.asked != proxy.next or self._wire.clock() >= proxy.asked_at + ON_THE_WAY_S:
                self._ask(proxy)
            self._ask_in(proxy, ASK_AGAIN_S)
        elif not heartbeat.is_final:
            self._acknowledge(proxy, [])

    def _skip(self, proxy: WriterProxy, first: int, *, is_loss: bool) -> None:
        """Wait no more for what is below `first`; what has come of it is delivered."""
        while proxy.next < first:
            if proxy.next in proxy.backlog.held:
                if self._is_paused:
                    return
                self._release(proxy)
                continue
            ahead = min((number for number in proxy.backlog.held if number < first), default=first)
            if is_loss:
                self._wire.tell(self.listener.on_lost, ahead - proxy.next)
            proxy.next = ahead
        proxy.backlog.drop_below(proxy.next)

    def on_gap(self, proxy: WriterProxy, gap: Gap) -> None:
        """Wait no more for samples that will not come."""
        if not proxy.is_reliable or not proxy.next:
            return
        base = gap.irrelevant.base
        end = min(base, proxy.next + bounds.AHEAD) if gap.first > proxy.next else base
        if gap.first <= proxy.next < base:
            self._skip(proxy, base, is_loss=False)
        elif gap.first > proxy.next:
            for number in range(gap.first, end):
                proxy.backlog.forget(number)
        for number in gap.irrelevant.numbers():
            if proxy.next <= number < proxy.next + bounds.AHEAD:
                proxy.backlog.forget(number)
        proxy.known = max(proxy.known, base - 1)
        self._release(proxy)

    def on_heartbeat_frag(self, proxy: WriterProxy, told: HeartbeatFrag) -> None:
        """Ask for the fragments that are missing of a sample that is being sent."""
        if not proxy.is_reliable or not proxy.next or not is_newer(told.counter, proxy.frag_counter):
            return
        proxy.frag_counter = told.counter
        begun = proxy.backlog.partials.get(told.number)
        missing = None if begun is None else begun.to_ask(self._wire.clock(), told.last)
        if missing is not None:
            self._send(proxy, self._nack_frag(proxy, told.number, missing))

    # ---- what is asked for

    def _is_missing(self, proxy: WriterProxy) -> bool:
        return proxy.next <= proxy.known and not (self._is_paused and proxy.next in proxy.backlog.held)

    def _ask(self, proxy: WriterProxy) -> None:
        """Send ACKNACK with what is missing, and again some time later if it does not come."""
        missing = [
            number
            for number in range(proxy.next, min(proxy.known, proxy.next + bounds.SET_BITS - 1) + 1)
            if number not in proxy.backlog.held
        ]
        self._acknowledge(proxy, missing)
        proxy.asked, proxy.asked_at = proxy.next, self._wire.clock()
        if missing:
            self._stop_timer(proxy)
            proxy.interval = ASK_AGAIN_S
            self._ask_in(proxy, proxy.interval)

    def _acknowledge(self, proxy: WriterProxy, missing: list[int]) -> None:
        partials = proxy.backlog.partials
        whole = [number for number in missing if number not in partials] if partials else missing
        proxy.sent_counter += 1
        acknack = AckNack(
            self.entity_id,
            proxy.entity_id,
            NumberSet.of(proxy.next, whole),
            proxy.sent_counter,
            is_final=True,
        )
        packet = acknack.encode()
        for number in list(partials)[:_MOST_PARTIALS_ASKED]:
            of_it = partials[number].to_ask(self._wire.clock())
            if of_it is not None:
                packet += self._nack_frag(proxy, number, of_it)
        self._send(proxy, packet)

    def _nack_frag(self, proxy: WriterProxy, number: int, missing: NumberSet) -> bytes:
        proxy.sent_counter += 1
        return NackFrag(self.entity_id, proxy.entity_id, number, missing, proxy.sent_counter).encode()

    def _send(self, proxy: WriterProxy, submessages: bytes) -> None:
        self._wire.send(self._wire.head + proxy.asks + submessages, proxy.address)

    def _ask_in(self, proxy: WriterProxy, delay_s: float) -> None:
        if proxy.timer is None:
            proxy.timer = self._wire.timers.at(self._wire.clock() + delay_s, partial(self._on_timer, proxy))

    def _stop_timer(self, proxy: WriterProxy) -> None:
        if proxy.timer is not None:
            proxy.timer.cancel()
            proxy.timer = None

    def _on_timer(self, proxy: WriterProxy) -> None:
        proxy.timer = None
        if not proxy.next:
            self._greet(proxy)
        elif self._is_missing(proxy):
            before = proxy.interval
            self._ask(proxy)
            proxy.interval = min(2 * before, RAREST_ASK_S)
            self._stop_timer(proxy)
            self._ask_in(proxy, proxy.interval)

    def _greet(self, proxy: WriterProxy) -> None:
        """Ask a writer for its first HEARTBEAT."""
        proxy.sent_counter += 1
        acknack = AckNack(self.entity_id, proxy.entity_id, NumberSet(1), proxy.sent_counter)
        self._send(proxy, acknack.encode())
        self._ask_in(proxy, proxy.interval)
        proxy.interval = min(2 * proxy.interval, RAREST_FIRST_ASK_S)

    # ---- writers that come and go

    def match(self, writer: EndpointData, address: Address) -> WriterProxy:
        """Take up a writer."""
        is_reliable = self._is_reliable and writer.qos.reliability == RELIABLE
        proxy = WriterProxy(self._wire, self, writer, address, is_reliable)
        self.writers[writer.guid] = proxy
        if writer.qos.lease < INFINITE:
            lease = max(writer.qos.lease / NS, bounds.LEAST_LEASE_S)
            proxy.watch = Watch(self._wire, lease, partial(self._note_silent, proxy))
        self._wire.tell(self.listener.on_matched, writer)
        if is_reliable:
            self._greet(proxy)
        return proxy

    def unmatch(self, guid: bytes) -> None:
        """Forget a writer."""
        proxy = self.writers.pop(guid, None)
        if proxy is not None:
            self._let_go(proxy)
            self._wire.tell(self.listener.on_unmatched, proxy.data)

    def _let_go(self, proxy: WriterProxy) -> None:
        self._stop_timer(proxy)
        proxy.backlog.clear()
        if proxy.watch is not None:
            proxy.watch.stop()

    def note_alive(self, proxy: WriterProxy) -> None:
        """A writer has shown that it lives."""
        if proxy.watch is not None:
            proxy.watch.heard = self._wire.clock()
        if not proxy.is_alive:
            proxy.is_alive = True
            self._wire.tell(self.listener.on_liveliness, proxy.data.guid, True)

    def _note_silent(self, proxy: WriterProxy) -> None:
        if proxy.is_alive:
            proxy.is_alive = False
            self._wire.tell(self.listener.on_liveliness, proxy.data.guid, False)

    def stop(self) -> None:
        """Read nothing more."""
        for proxy in self.writers.values():
            self._let_go(proxy)
        self.writers.clear()
        if self._deadline is not None:
            self._deadline.stop()
