"""The GUID prefix of goalwire's participants, which names the port that their packets come from.

The system gives a port to one program at a time. So another program of the host cannot send packets in the
name of one of goalwire's participants there: it cannot have the port. Participants of other vendors choose
their prefixes by other rules, and send from any port. Packets that another program of their host sends in
their name cannot be told from their own.
"""

from __future__ import annotations

from goalwire.rtps.protocol.messages import VENDOR

RANDOM_SIZE = 8
"""Random bytes of a prefix, which make it unique among all hosts."""


def make_prefix(port: int, random: bytes) -> bytes:
    """Return the prefix of a participant that sends all its packets from a port."""
    return VENDOR + port.to_bytes(2, 'big') + random


def may_come_from(prefix: bytes, port: int) -> bool:
    """Return True if a packet in the name of a participant of this host may come from a port."""
    return prefix[:2] != VENDOR or int.from_bytes(prefix[2:4], 'big') == port
