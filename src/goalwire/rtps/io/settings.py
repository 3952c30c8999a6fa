"""The settings of a session: plain values, which know nothing of any file or variable."""

from __future__ import annotations

from goalwire.concurrency.poller import IS_PORTABLE
from goalwire.records import record
from goalwire.rtps.io.addresses import (
    ANNOUNCED_PARTICIPANTS,
    GROUP,
    GROUPS_V6,
    STANDARD,
    Ports,
    Reach,
)

BUFFER_SIZE = 4 << 20
"""Bytes that a socket is asked to hold; the system may give it less."""


@record
class Settings:
    """The values that a session is opened with."""

    domain: int = 0
    reach: Reach = Reach.LOCALHOST
    peers: tuple[str, ...] = ()
    """Further hosts that it announces itself to: HOST, or HOST:PORT."""
    user_data: bytes = b''
    name: str = ''
    lease_s: float = 20.0
    portable: bool = IS_PORTABLE
    """Whether to do without what only Linux has."""
    interfaces: tuple[str, ...] = ()
    """Names or addresses of the interfaces to be used; none: all."""
    excluded: tuple[str, ...] = ()
    """Names or addresses of interfaces that are not used."""
    multicast: bool = True
    """Whether groups are joined, if the subnet is looked at."""
    group: str = ''
    """The multicast group of discovery; empty: the standard's."""
    announces_to_group: bool = True
    """Whether it announces itself there."""
    announces_here: bool = True
    """Whether it announces itself to the participants of this machine by unicast."""
    ports: Ports = STANDARD
    participant: int | None = None
    """The index of the ports that it takes, from 0; None: the first that are free."""
    participants: int = ANNOUNCED_PARTICIPANTS
    """Participants of each peer that it announces itself to."""
    tag: str = ''
    """Participants with another tag do not see it."""
    announce_s: float = 3.0
    """How often it announces itself."""
    packet_size: int | None = None
    """Bytes of a packet at most; None: 60 kB to readers on this machine, 1.4 to 8 kB to others."""
    receive_buffer: int = BUFFER_SIZE
    send_buffer: int = BUFFER_SIZE
    """Bytes that sockets are asked to hold; the system may give less."""
    ipv6: bool = False
    """Whether to speak IPv6 in place of IPv4."""

    @property
    def groups(self) -> tuple[str, ...]:
        """The multicast groups that it joins; none without multicast."""
        if self.reach is not Reach.SUBNET or not self.multicast:
            return ()
        return (self.group,) if self.group else GROUPS_V6 if self.ipv6 else (GROUP,)
