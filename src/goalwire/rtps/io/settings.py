"""The settings of a session: plain values, independent of files and environment variables."""

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
"""The size of a socket's buffer to ask for, in bytes; the system may give less."""


@record
class Settings:
    """The values for opening a session."""

    domain: int = 0
    reach: Reach = Reach.LOCALHOST
    peers: tuple[str, ...] = ()
    """Further hosts to which the participant announces itself: HOST, or HOST:PORT."""
    user_data: bytes = b''
    name: str = ''
    lease_s: float = 20.0
    portable: bool = IS_PORTABLE
    """True to use no features that only Linux has."""
    interfaces: tuple[str, ...] = ()
    """Names or addresses of the interfaces to use; empty: all."""
    excluded: tuple[str, ...] = ()
    """Names or addresses of interfaces not to use."""
    multicast: bool = True
    """True to join the multicast groups, if the reach is the subnet."""
    group: str = ''
    """The multicast group of discovery; empty: the standard's."""
    announces_to_group: bool = True
    """True to send announcements to the multicast groups."""
    announces_here: bool = True
    """True to announce the participant by unicast to the participants of this machine."""
    ports: Ports = STANDARD
    participant: int | None = None
    """The participant index, from 0, which determines the ports; None: the first free one."""
    participants: int = ANNOUNCED_PARTICIPANTS
    """How many participants of each peer get announcements."""
    tag: str = ''
    """Participants with different tags ignore each other."""
    announce_s: float = 3.0
    """How often the participant announces itself."""
    packet_size: int | None = None
    """The largest packet in bytes; None: 60 kB to readers on this machine, 1.4 to 8 kB to others."""
    receive_buffer: int = BUFFER_SIZE
    send_buffer: int = BUFFER_SIZE
    """The size of the sockets' buffers to ask for, in bytes; the system may give less."""
    ipv6: bool = False
    """True to use IPv6 instead of IPv4."""

    @property
    def groups(self) -> tuple[str, ...]:
        """The multicast groups to join; empty without multicast."""
        if self.reach is not Reach.SUBNET or not self.multicast:
            return ()
        return (self.group,) if self.group else GROUPS_V6 if self.ipv6 else (GROUP,)
