"""A writer, as its reader knows it: what has come of it, and what it is asked for."""

from __future__ import annotations

from goalwire.rtps.protocol.announcements import EndpointData
from goalwire.rtps.protocol.backlog import Backlog
from goalwire.rtps.protocol.messages import info_dst
from goalwire.rtps.protocol.primitives import Address
from goalwire.rtps.protocol.wire import Timer, Watch, Wire

FIRST_ASK_S = 0.005
"""How long after a match a writer is asked again for its first HEARTBEAT."""


class WriterProxy:
    """One writer, as a reader knows it."""

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
        """INFO_DST of its participant."""
        self.is_reliable = is_reliable
        self.matched_at = wire.clock()
        self.next = 0
        """The sample that is delivered next; 0 until that is known."""
        self.known = 0
        """The last sample that the writer is known to have."""
        self.lost = 0
        """Samples before `next` that are lost, and of which the user has not been told."""
        self.backlog = Backlog(wire)
        self.counter: int | None = None
        self.frag_counter: int | None = None
        """Of its last HEARTBEAT and HEARTBEAT_FRAG: one that comes twice counts once."""
        self.sent_counter = 0
        """Of what was sent to it last."""
        self.asked, self.asked_at = 0, 0.0
        """From which sample on others were asked for last, and when."""
        self.timer: Timer | None = None
        self.interval = FIRST_ASK_S
        self.watch: Watch | None = None
        """Over its liveliness, where that has a lease."""
        self.is_alive = True
        self._skipped_from = self._skipped_to = 0

    # ---- what was skipped

    def begin(self, first: int) -> None:
        """Wait for `first`: the writer has told, for the first time, which samples it has."""
        self.next = self._skipped_to = first

    def skip(self, first: int, *, is_loss: bool = False) -> None:
        """Wait no more for what is below `first`: somebody has told that it will not come.

        That is not known for certain. Any program of the writer's host could send a HEARTBEAT or a GAP in the
        writer's name, with any numbers. As long as nothing behind what was skipped has been delivered, the
        writer may prove that it is not so, and then nothing is lost and no order is broken.
        """
        if self._skipped_to != self.next or not self._skipped_from:
            self._skipped_from = self.next
        if is_loss:
            self.lost += first - self.next
        self.next = self._skipped_to = first

    def was_skipped(self, number: int) -> bool:
        """Whether a sample comes of which was told that it would not, and nothing behind it was delivered."""
        return self._skipped_to == self.next and 0 < self._skipped_from <= number < self.next

    def take_back_skip(self) -> None:
        """Wait for what was skipped."""
        self.next = self.known = self._skipped_from
        self._skipped_from = self._skipped_to = self.lost = 0

    def correct(self, last: int) -> None:
        """The writer's last sample is `last`: if even the one behind it was skipped, that was not true."""
        if last + 1 < self.next == self._skipped_to:
            self.next = self._skipped_from or last + 1
            self._skipped_to, self.lost = self.next, 0
