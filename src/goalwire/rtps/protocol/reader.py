"""A reader: puts its writers' samples in order, and requests missing ones.

A reliable reader delivers the samples of each writer in the order of their numbers. An early sample is held
back. A missing sample is requested by ACKNACK as soon as HEARTBEAT says that it exists, or a moment after a
later sample came, and again if it does not come. A best-effort reader delivers samples as they come, and
drops late ones.

A reader does not know the number of the first sample that a writer has for it. So it asks when the two match
(by the *preemptive* ACKNACK), and holds samples back until the writer's first HEARTBEAT tells the number.
"""

from __future__ import annotations

from functools import partial

from goalwire.rtps.protocol import bounds
from goalwire.rtps.protocol.announcements import EndpointData
from goalwire.rtps.protocol.backlog import Sample
from goalwire.rtps.protocol.messages import DataFrag, Gap, Heartbeat
from goalwire.rtps.protocol.primitives import INFINITE, NS, Address, is_keyed
from goalwire.rtps.protocol.qos import RELIABLE, TRANSIENT_LOCAL
from goalwire.rtps.protocol.reader_requests import ASK_AGAIN_S, GAP_S, Requests
from goalwire.rtps.protocol.wire import Watch, Wire
from goalwire.rtps.protocol.writer_proxy import WriterProxy

__all__ = ['Reader', 'ReaderListener', 'Sample', 'WriterProxy']


class ReaderListener:
    """The callbacks of a reader. Every method is called without any lock held."""

    def on_sample(self, sample: Sample) -> None:
        """Called with each sample, in the order of delivery."""

    def on_matched(self, writer: EndpointData) -> None:
        """Called when a writer has been matched: the writer's samples come from now on."""

    def on_answered(self, writer: EndpointData) -> None:
        """Called at a reliable writer's first HEARTBEAT, which shows that the writer knows the reader."""

    def on_unmatched(self, writer: EndpointData) -> None:
        """Called when a matched writer has gone."""

    def on_incompatible(self, writer: EndpointData, policy: str) -> None:
        """Called if a writer of the topic offers less in the policy `policy` than the reader requests."""

    def on_lost(self, count: int) -> None:
        """Called if `count` samples are lost: they will not come any more."""

    def on_deadline_missed(self) -> None:
        """Called if no sample came within the deadline."""

    def on_liveliness(self, writer: bytes, is_alive: bool) -> None:
        """Called when a writer's liveliness lease has ended, or the writer is alive again."""


class Reader:
    """A reader of one topic. Its methods are called inside `Wire.run`, unless they say otherwise."""

    def __init__(self, wire: Wire, data: EndpointData, listener: ReaderListener) -> None:
        self.data = data
        self.listener = listener
        self.entity_id = data.entity_id
        self.writers: dict[bytes, WriterProxy] = {}
        self._wire = wire
        self._is_reliable = data.qos.reliability == RELIABLE
        self._requests = Requests(wire, data.entity_id)
        self.on_heartbeat_frag = self._requests.on_heartbeat_frag
        self._tell_sample = listener.on_sample
        self._post = wire.post
        self._most_history = 0
        """How many samples from before the match it takes; 0: all that the writer has."""
        if data.qos.durability >= TRANSIENT_LOCAL and not is_keyed(data.entity_id):
            self._most_history = max(data.qos.depth, 0)
        self._deadline: Watch | None = None

    def start(self) -> None:
        """Watch the reader's deadline from now on."""
        wire, deadline = self._wire, self.data.qos.deadline
        if deadline < INFINITE:
            self._deadline = Watch(wire, deadline / NS, partial(wire.tell, self.listener.on_deadline_missed))

    # ---- pausing for a slow user

    def pause(self) -> None:
        """Deliver and acknowledge no more samples until `resume`. May be called on any thread.

        A reliable writer with KEEP_ALL then waits. Samples that come meanwhile are held back within bounds.
        """
        self._wire.run(partial(setattr, self._requests, 'is_paused', True), None)

    def resume(self) -> None:
        """End the pause: deliver the samples held back so far, then later ones. Any thread may call this."""
        self._wire.run(self._resume, None)

    def _resume(self) -> None:
        self._requests.is_paused = False
        for proxy in self.writers.values():
            self._release(proxy)
            if proxy.is_reliable and proxy.next:
                self._requests.ask(proxy)

    # ---- samples and other messages from writers

    def on_sample(self, proxy: WriterProxy, sample: Sample) -> None:
        """Take a sample."""
        number = sample.number
        if proxy.watch is not None:
            self.note_alive(proxy)
        backlog = proxy.backlog
        if number == proxy.next and not self._requests.is_paused:
            proxy.next = number + 1
            if backlog.partials:
                backlog.drop_partial(number)
            self._deliver(proxy, sample)
            if backlog.held:
                self._release(proxy)
        elif not proxy.is_reliable:
            is_newer = number >= proxy.next or number + bounds.AHEAD < proxy.next
            if is_newer and not self._requests.is_paused:
                if proxy.next and number > proxy.next:
                    proxy.lost = number - proxy.next
                proxy.next = number + 1
                if backlog.partials:
                    backlog.drop_partials(lambda key: key <= number)
                self._deliver(proxy, sample)
        elif number >= proxy.next:
            if backlog.held.get(number) is None:
                self._hold(proxy, sample)
        elif proxy.was_skipped(number):
            proxy.take_back_skip()
            self.on_sample(proxy, sample)

    def _hold(self, proxy: WriterProxy, sample: Sample) -> None:
        """Keep a sample until all earlier ones have come. Beyond the bounds it is requested again later."""
        if not proxy.backlog.hold(sample, proxy.next):
            return
        if not proxy.next:
            self._requests.greet_anew(proxy)
        self._release(proxy)
        if proxy.next and sample.number > proxy.next:
            proxy.known = max(proxy.known, sample.number)
            self._requests.ask_in(proxy, GAP_S)

    def _release(self, proxy: WriterProxy) -> None:
        """Deliver the held samples whose turn has come."""
        backlog = proxy.backlog
        if not proxy.next:
            return
        while proxy.next in backlog.held and not self._requests.is_paused:
            sample = backlog.take(proxy.next)
            if sample is None:
                proxy.skip(proxy.next + 1)
            else:
                proxy.next += 1
                self._deliver(proxy, sample)

    def _deliver(self, proxy: WriterProxy, sample: Sample) -> None:
        if proxy.lost:
            self._wire.tell(self.listener.on_lost, proxy.lost)
            proxy.lost = 0
        lifespan = proxy.data.qos.lifespan
        if lifespan < INFINITE and sample.time and sample.time + lifespan < self._wire.wall_clock_ns():
            return
        if self._deadline is not None:
            self._deadline.heard = self._wire.clock()
        self._post(partial(self._tell_sample, sample))

    def on_fragment(self, proxy: WriterProxy, fragment: DataFrag, time: int | None) -> None:
        """Take some fragments of a sample; raises RtpsError for fragments that do not fit together."""
        number = fragment.number
        if proxy.watch is not None:
            self.note_alive(proxy)
        if number < proxy.next:
            if not proxy.is_reliable or not proxy.was_skipped(number):
                return
            proxy.take_back_skip()
        if proxy.backlog.held.get(number) is not None or (self._requests.is_paused and not proxy.is_reliable):
            return
        begun = proxy.backlog.add(fragment, proxy.next, is_reliable=proxy.is_reliable)
        if begun is None:
            return
        if begun.is_whole:
            proxy.backlog.drop_partial(number)
            guid = proxy.data.guid
            self.on_sample(proxy, Sample(guid, number, time, begun.payload, begun.qos, begun.is_key))
        elif proxy.is_reliable and proxy.next:
            proxy.known = max(proxy.known, number)
            if proxy.timer is None:
                proxy.interval = ASK_AGAIN_S
            self._requests.ask_in(proxy, ASK_AGAIN_S)

    def on_heartbeat(self, proxy: WriterProxy, heartbeat: Heartbeat) -> None:
        """Take a HEARTBEAT: note which samples the writer has, and request the missing ones."""
        if proxy.watch is not None and heartbeat.asserts_liveliness:
            self.note_alive(proxy)
        if not proxy.is_reliable or heartbeat.counter == proxy.counter:
            return
        proxy.counter = heartbeat.counter
        first = heartbeat.first
        if not proxy.next:
            if self._most_history:
                first = max(first, heartbeat.last - self._most_history + 1)
            proxy.begin(first)
            self._requests.stop_timer(proxy)
            proxy.backlog.drop_below(first)
            self._wire.tell(self.listener.on_answered, proxy.data)
        elif first > proxy.next:
            self._skip(proxy, first, is_loss=True)
        else:
            proxy.correct(heartbeat.last)
            if first > proxy.next:
                self._skip(proxy, first, is_loss=True)
        proxy.known = heartbeat.last
        self._release(proxy)
        self._requests.answer(proxy, is_final=heartbeat.is_final)

    def _skip(self, proxy: WriterProxy, first: int, *, is_loss: bool) -> None:
        """Stop waiting for samples below `first`; deliver those below it that have come."""
        while proxy.next < first:
            if proxy.next in proxy.backlog.held:
                if self._requests.is_paused:
                    return
                self._release(proxy)
                continue
            ahead = min((number for number in proxy.backlog.held if number < first), default=first)
            proxy.skip(ahead, is_loss=is_loss)
        proxy.backlog.drop_below(proxy.next)

    def on_gap(self, proxy: WriterProxy, gap: Gap) -> None:
        """Take a GAP: stop waiting for the samples that it says will not come."""
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

    # ---- matching with writers

    def match(self, writer: EndpointData, address: Address) -> WriterProxy:
        """Add a writer."""
        is_reliable = self._is_reliable and writer.qos.reliability == RELIABLE
        proxy = WriterProxy(self._wire, writer, address, is_reliable)
        self.writers[writer.guid] = proxy
        if writer.qos.lease < INFINITE:
            lease = max(writer.qos.lease / NS, bounds.LEAST_LEASE_S)
            proxy.watch = Watch(self._wire, lease, partial(self._note_silent, proxy))
        self._wire.tell(self.listener.on_matched, writer)
        if is_reliable:
            self._requests.greet(proxy)
        return proxy

    def unmatch(self, guid: bytes) -> None:
        """Forget a writer."""
        proxy = self.writers.pop(guid, None)
        if proxy is not None:
            self._let_go(proxy)
            self._wire.tell(self.listener.on_unmatched, proxy.data)

    def _let_go(self, proxy: WriterProxy) -> None:
        self._requests.stop_timer(proxy)
        proxy.backlog.clear()
        if proxy.watch is not None:
            proxy.watch.stop()

    def note_alive(self, proxy: WriterProxy) -> None:
        """Note that a writer has shown that it lives."""
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
        """Stop reading."""
        for proxy in self.writers.values():
            self._let_go(proxy)
        self.writers.clear()
        if self._deadline is not None:
            self._deadline.stop()
