"""A reader's requests to its writers: for the first HEARTBEAT, samples, and fragments of samples.

Missing samples are requested by ACKNACK, and again at growing intervals until they come.
"""

from __future__ import annotations

from functools import partial

from goalwire.rtps.protocol import bounds
from goalwire.rtps.protocol.messages import AckNack, HeartbeatFrag, NackFrag
from goalwire.rtps.protocol.primitives import NumberSet
from goalwire.rtps.protocol.wire import Wire
from goalwire.rtps.protocol.writer_proxy import FIRST_ASK_S, WriterProxy

GAP_S = 0.002
"""How long a sample that others have overtaken may be late before it is requested."""
ASK_AGAIN_S = 0.020
"""How long a requested sample may take before it is requested again; this time doubles at each request."""
ON_THE_WAY_S = 0.002
"""How long a requested sample may take before a HEARTBEAT leads to a new request.

Without this time, a writer and a reader that disagree about the existing samples would ask and answer without
a pause.
"""
RAREST_ASK_S = 0.5
RAREST_FIRST_ASK_S = 1.0
_MOST_PARTIALS_ASKED = 4
"""How many samples' fragments are requested at a time."""


class Requests:
    """Sends the requests of one reader. Methods are called inside `Wire.run`."""

    def __init__(self, wire: Wire, entity_id: bytes) -> None:
        """Make the requests of the reader with this `entity_id`."""
        self._wire = wire
        self._entity_id = entity_id
        self.is_paused = False
        """True while new samples are not acknowledged, because the reader's user is slow."""

    def greet(self, proxy: WriterProxy) -> None:
        """Ask a writer for its first HEARTBEAT."""
        proxy.sent_counter += 1
        acknack = AckNack(self._entity_id, proxy.entity_id, NumberSet(1), proxy.sent_counter)
        self._send(proxy, acknack.encode())
        self.ask_in(proxy, proxy.interval)
        proxy.interval = min(2 * proxy.interval, RAREST_FIRST_ASK_S)

    def greet_anew(self, proxy: WriterProxy) -> None:
        """Ask for the first HEARTBEAT at once, since a sample waits for it.

        RustDDS sends no HEARTBEAT before its first sample.
        """
        if len(proxy.backlog.held) == 1:
            self.stop_timer(proxy)
            proxy.interval = FIRST_ASK_S
            self.greet(proxy)

    def answer(self, proxy: WriterProxy, *, is_final: bool) -> None:
        """Answer a HEARTBEAT: request missing samples, or acknowledge if an answer is required."""
        if self._is_missing(proxy):
            if proxy.asked != proxy.next or self._wire.clock() >= proxy.asked_at + ON_THE_WAY_S:
                self.ask(proxy)
            self.ask_in(proxy, ASK_AGAIN_S)
        elif not is_final:
            self._acknowledge(proxy, [])

    def ask(self, proxy: WriterProxy) -> None:
        """Request the missing samples by ACKNACK, and again some time later if they do not come."""
        missing = [
            number
            for number in range(proxy.next, min(proxy.known, proxy.next + bounds.SET_BITS - 1) + 1)
            if number not in proxy.backlog.held
        ]
        self._acknowledge(proxy, missing)
        proxy.asked, proxy.asked_at = proxy.next, self._wire.clock()
        if missing:
            self.stop_timer(proxy)
            proxy.interval = ASK_AGAIN_S
            self.ask_in(proxy, proxy.interval)

    def ask_in(self, proxy: WriterProxy, delay_s: float) -> None:
        """Plan a request after a delay, for samples still missing then; an earlier plan stays."""
        if proxy.timer is None:
            proxy.timer = self._wire.timers.at(self._wire.clock() + delay_s, partial(self._on_timer, proxy))

    def stop_timer(self, proxy: WriterProxy) -> None:
        """Cancel the planned request to a writer."""
        if proxy.timer is not None:
            proxy.timer.cancel()
            proxy.timer = None

    def on_heartbeat_frag(self, proxy: WriterProxy, told: HeartbeatFrag) -> None:
        """Request the missing fragments of a sample that is being sent."""
        if not proxy.is_reliable or not proxy.next or told.counter == proxy.frag_counter:
            return
        proxy.frag_counter = told.counter
        begun = proxy.backlog.partials.get(told.number)
        missing = None if begun is None else begun.to_ask(self._wire.clock(), told.last)
        if missing is not None:
            self._send(proxy, self._nack_frag(proxy, told.number, missing))

    def _is_missing(self, proxy: WriterProxy) -> bool:
        return proxy.next <= proxy.known and not (self.is_paused and proxy.next in proxy.backlog.held)

    def _acknowledge(self, proxy: WriterProxy, missing: list[int]) -> None:
        partials = proxy.backlog.partials
        whole = [number for number in missing if number not in partials] if partials else missing
        proxy.sent_counter += 1
        acknack = AckNack(
            self._entity_id,
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
        return NackFrag(self._entity_id, proxy.entity_id, number, missing, proxy.sent_counter).encode()

    def _send(self, proxy: WriterProxy, submessages: bytes) -> None:
        self._wire.send(self._wire.head + proxy.asks + submessages, proxy.address)

    def _on_timer(self, proxy: WriterProxy) -> None:
        proxy.timer = None
        if not proxy.next:
            self.greet(proxy)
        elif self._is_missing(proxy):
            before = proxy.interval
            self.ask(proxy)
            proxy.interval = min(2 * before, RAREST_ASK_S)
            self.stop_timer(proxy)
            self.ask_in(proxy, proxy.interval)
