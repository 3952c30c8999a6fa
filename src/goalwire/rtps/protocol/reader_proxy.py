"""A reader, as its writer knows it: what it has, and when it is asked again."""

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
"""How long after a sample its readers are asked whether they have it."""


class ReaderProxy:
    """One reader, as its writer knows it."""

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
        'pushed_at',
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
        self.addressed: deque[Change] = deque()
        self.addressed_size = 0
        """What is meant for it alone and not acknowledged, and the bytes of that."""
        self.counter: int | None = None
        self.frag_counter: int | None = None
        """Of its last ACKNACK and NACK_FRAG: one that comes twice counts once."""
        self.has_answered = False
        self.pushed_at = -FOREVER
        """When it was last sent, unasked, all that it lacks."""
        self.interval = FIRST_HEARTBEAT_S
        self.due = FOREVER
        """When it is asked next."""
