"""The settings with which a session is opened."""

from __future__ import annotations

from goalwire.concurrency.poller import IS_PORTABLE
from goalwire.records import record
from goalwire.zenoh.io.dialler import Retry
from goalwire.zenoh.io.endpoints import TlsFiles
from goalwire.zenoh.io.identities import Identify
from goalwire.zenoh.protocol.transport import Role


@record
class MemorySettings:
    """With whom a session shares memory, and how much."""

    with_own: bool = False
    """Whether it shares with sessions of goalwire's on the same machine."""
    with_all: bool = False
    """Whether it shares with any Zenoh session that offers it."""
    pool_size: int = 48 << 20
    """Bytes of the pool; rmw_zenoh's default since 0.2.8."""
    least: int = 65536
    """Bytes of the smallest payload that goes through it."""


@record
class Settings:
    """The settings with which a session is opened."""

    role: Role = Role.PEER
    connect: tuple[str, ...] = ()
    listen: tuple[str, ...] = ('tcp/localhost:0',)
    zid: bytes = b''
    """The session's id; empty: drawn by chance."""
    lease_ms: int = 60_000
    retry: Retry = Retry()
    meets_peers: bool = True
    """Whether it connects to peers that routers tell of."""
    tls: TlsFiles = TlsFiles()
    """For addresses that begin with tls/."""
    identify: Identify | None = None
    """Names the other side of a TLS link by its certificate. If it is set, every link needs TLS."""
    token_keys: tuple[str, ...] = ()
    """The key expressions of the tokens that routers are asked for; empty: all tokens."""
    memory: MemorySettings = MemorySettings()
    """With whom it shares memory."""
    untimed_s: float = 600.0
    """How long a query without a time may take; rmw_zenoh's ten minutes."""
    must_connect: bool | None = None
    """Whether opening fails if `connect` is not reached; None: a client's does, a peer's does not."""
    connecting_s: float = 0.0
    """How long opening goes on trying if it must connect; 0: each address once."""
    passes_on: bool = True
    """Whether a router serves clients; if not, it only introduces peers to each other."""
    portable: bool = IS_PORTABLE
    """True to avoid what only Linux offers."""
    advice: str = 'check that these addresses can be reached'
    """The advice of the error that is raised if `connect` must be reached and is not."""

    @property
    def fails_unconnected(self) -> bool:
        """Whether opening fails if `connect` is not reached."""
        return self.role is Role.CLIENT if self.must_connect is None else self.must_connect
