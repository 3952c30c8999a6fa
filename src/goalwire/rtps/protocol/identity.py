"""The GUID prefix of goalwire's participants, which names the port that their packets come from.

The system gives a port to one program at a time. So no other program on a host can send packets in the name
of a goalwire participant on that host: it cannot bind the participant's port. Participants of other vendors
choose their prefixes by other rules, and send from any port. If another program on the same host forges
packets of such a participant, that is not detected.
"""

from __future__ import annotations

from goalwire.rtps.protocol.messages import VENDOR

RANDOM_SIZE = 8
"""Random bytes of a prefix, which make it unique among all hosts."""


def make_prefix(port: int, random: bytes) -> bytes:
    """Return a new GUID prefix for a participant that sends all its packets from `port`."""
    return VENDOR + port.to_bytes(2, 'big') + random


def may_come_from(prefix: bytes, port: int) -> bool:
    """Return True if a packet with the GUID prefix of a participant on this host may come from a port."""
    return prefix[:2] != VENDOR or int.from_bytes(prefix[2:4], 'big') == port
