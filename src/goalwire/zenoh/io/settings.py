"""The settings with which a session is opened."""

from __future__ import annotations

from goalwire.concurrency.poller import IS_PORTABLE
from goalwire.records import record
from goalwire.zenoh.io.dialler import Retry
from goalwire.zenoh.io.endpoints import TlsFiles
from goalwire.zenoh.io.identities import Identify
from goalwire.zenoh.protocol import bounds
from goalwire.zenoh.protocol.link_messages import Role


@record
class MemorySettings:
    """The peers that a session shares memory with, and the sizes of that memory."""

    with_own: bool = False
    """True to share memory with goalwire's sessions on the same machine."""
    with_all: bool = False
    """True to share memory with any Zenoh session that offers it."""
    pool_size: int = 48 << 20
    """Bytes of the pool; rmw_zenoh's default since 0.2.8."""
    least: int = 65536
    """Bytes of the smallest payload that goes through shared memory."""


@record
class Settings:
    """The settings with which a session is opened."""

    role: Role = Role.PEER
    connect: tuple[str, ...] = ()
    listen: tuple[str, ...] = ('tcp/localhost:0',)
    zid: bytes = b''
    """The session's id; empty: a random one."""
    lease_ms: int = 60_000
    retry: Retry = Retry()
    open_s: float = bounds.HANDSHAKE_S
    """How long the handshake with a configured address may take at most, in s."""
    meets_peers: bool = True
    """True to connect to peers that routers announce."""
    tls: TlsFiles = TlsFiles()
    """The TLS files for addresses that begin with tls/."""
    identify: Identify | None = None
    """Identifies the other side of a TLS link by its certificate. If it is set, every link needs TLS."""
    token_keys: tuple[str, ...] = ()
    """The key expressions of the tokens that routers are asked for; empty: all tokens."""
    entity_keys: tuple[str, ...] | None = None
    """The key expressions of the subscribers and queryables that routers are asked for; None: all. Needs
    `token_keys`. Keys that are used later are asked for, too."""
    memory: MemorySettings = MemorySettings()
    """The settings of shared memory."""
    untimed_s: float = 600.0
    """The timeout of queries that set none, in s: rmw_zenoh's ten minutes."""
    must_connect: bool | None = None
    """True if opening fails when no address of `connect` answers; None: True for clients, False for peers."""
    connecting_s: float = 0.0
    """How long opening keeps trying if it must connect, in s; 0: it tries each address once."""
    passes_on: bool = True
    """True if a router serves clients; otherwise it only introduces peers to each other."""
    portable: bool = IS_PORTABLE
    """True to avoid what only Linux offers."""
    advice: str = 'check that these addresses can be reached'
    """The advice in the error that opening raises if `connect` must be reached and does not answer."""

    @property
    def fails_unconnected(self) -> bool:
        """True if opening fails when no address of `connect` answers."""
        return self.role is Role.CLIENT if self.must_connect is None else self.must_connect
