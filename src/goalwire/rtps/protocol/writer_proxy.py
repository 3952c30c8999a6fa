"""A reader's record of one writer: which samples have come, and which have been requested.

`reader` puts the samples in order, `reader_requests` requests those that are missing.
"""

from __future__ import annotations

from goalwire.rtps.protocol.announcements import EndpointData
from goalwire.rtps.protocol.backlog import Backlog
from goalwire.rtps.protocol.messages import info_dst
from goalwire.rtps.protocol.primitives import Address
from goalwire.rtps.protocol.wire import Timer, Watch, Wire

FIRST_ASK_S = 0.005
"""How long after a match a reader asks a silent writer again for its first HEARTBEAT."""


class WriterProxy:
    """A reader's record of one writer."""

    __slots__ = (
        '_skipped_from',
        '_skipped_to',
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
        'lost',
        'matched_at',
        'next',
        'sent_counter',
        'timer',
        'watch',
    )

    def __init__(self, wire: Wire, data: EndpointData, address: Address, is_reliable: bool) -> None:
        self.data = data
        self.address = address
        self.entity_id = data.entity_id
        self.asks = info_dst(data.prefix)
        """INFO_DST for the writer's participant."""
        self.is_reliable = is_reliable
        self.matched_at = wire.clock()
        self.next = 0
        """The next sample to deliver; 0 until that is known."""
        self.known = 0
        """The last sample that the writer has told of."""
        self.lost = 0
        """Lost samples before `next` that have not been reported to the user."""
        self.backlog = Backlog(wire)
        self.counter: int | None = None
        self.frag_counter: int | None = None
        """The counts of its last HEARTBEAT and HEARTBEAT_FRAG: so a duplicate is ignored."""
        self.sent_counter = 0
        """The count of the last ACKNACK or NACK_FRAG to it."""
        self.asked, self.asked_at = 0, 0.0
        """The first sample of the last request, and the request's time."""
        self.timer: Timer | None = None
        self.interval = FIRST_ASK_S
        self.watch: Watch | None = None
        """The watch over its liveliness, if that has a lease."""
        self.is_alive = True
        self._skipped_from = self._skipped_to = 0

    # ---- skipped samples

    def begin(self, first: int) -> None:
        """Wait for the sample `first`, which the writer's first HEARTBEAT has named."""
        self.next = self._skipped_to = first

    def skip(self, first: int, *, is_loss: bool = False) -> None:
        """Stop waiting for samples below `first`, which a HEARTBEAT or a GAP says will not come.

        The HEARTBEAT or GAP may be forged: any program on the writer's host could send it in the writer's
        name. As long as no sample after the skipped ones has been delivered, a HEARTBEAT or sample from the
        writer itself undoes the skip; then no sample is lost and the order is kept.
        """
        if self._skipped_to != self.next or not self._skipped_from:
            self._skipped_from = self.next
        if is_loss:
            self.lost += first - self.next
        self.next = self._skipped_to = first

    def was_skipped(self, number: int) -> bool:
        """Return True if `number` is a skipped sample that may still be delivered, since no later one was."""
        return self._skipped_to == self.next and 0 < self._skipped_from <= number < self.next

    def take_back_skip(self) -> None:
        """Undo the last skip: wait for the skipped samples again."""
        self.next = self.known = self._skipped_from
        self._skipped_from = self._skipped_to = self.lost = 0

    def correct(self, last: int) -> None:
        """Undo a skip that went beyond the writer's last sample `last`, since that skip was false."""
        if last + 1 < self.next == self._skipped_to:
            self.next = self._skipped_from or last + 1
            self._skipped_to, self.lost = self.next, 0
