"""A writer's record of one reader: the samples that it has acknowledged, and when it is asked again."""

from __future__ import annotations

from collections import deque

from goalwire.rtps.protocol.announcements import EndpointData
from goalwire.rtps.protocol.history import Change
from goalwire.rtps.protocol.messages import info_dst
from goalwire.rtps.protocol.primitives import Address
from goalwire.rtps.protocol.wire import FOREVER

FIRST_HEARTBEAT_S = 0.005
"""How long after a match an unanswered HEARTBEAT is sent again."""
HEARTBEAT_S = 0.010
"""How long after a sample its readers are asked by HEARTBEAT if they have it."""
MOST_PATIENCE_S = 0.080
"""The same, at most, for a reader on this host that has lacked nothing when it was last asked.

A client that calls every 16 ms would otherwise be asked about each reply, and ask about each request. These
questions and their answers are four packets, in addition to the two of the call.
"""


class ReaderProxy:
    """A writer's record of one reader."""

    __slots__ = (
        'acked',
        'address',
        'addressed',
        'addressed_size',
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
        'most_patience',
        'patience',
        'pushed_at',
        'received',
        'start',
    )

    def __init__(self, data: EndpointData, address: Address, is_reliable: bool, start: int) -> None:
        self.data = data
        self.address = address
        self.entity_id = data.entity_id
        self.asks = info_dst(data.prefix)
        """INFO_DST for the reader's participant."""
        self.is_reliable = is_reliable
        self.start = start
        """The first sample that the reader should get."""
        self.acked = start - 1
        """All samples up to this one are acknowledged, or are not for this reader."""
        self.received = 0
        """The last sample that it has shown to have without an ACKNACK; `acked` may follow later."""
        self.last = start - 1
        """The last sample sent to it, if samples are addressed to single readers."""
        self.addressed: deque[Change] = deque()
        self.addressed_size = 0
        """The unacknowledged samples that only this reader gets, and their bytes."""
        self.counter: int | None = None
        self.frag_counter: int | None = None
        """The counts of its last ACKNACK and NACK_FRAG: so a duplicate is ignored."""
        self.has_answered = False
        self.pushed_at = -FOREVER
        """When all missing samples were last sent to it without a request."""
        self.interval = FIRST_HEARTBEAT_S
        self.patience = self.most_patience = HEARTBEAT_S
        """How long after a small sample it is asked, now and at most. This time doubles with each
        acknowledgement, and begins anew if a sample was missing."""
        self.due = FOREVER
        """When the next HEARTBEAT to it is due."""

    def longest_wait(self) -> float:
        """Return how long after a small sample the reader is asked."""
        return max(self.interval, self.patience) if self.has_answered else self.interval
