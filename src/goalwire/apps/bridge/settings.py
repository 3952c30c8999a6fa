"""Settings of a bridge: where it listens, who may connect, what clients may do, and how much may wait."""

from __future__ import annotations

from goalwire.apps.bridge.permissions import Permissions
from goalwire.records import record
from goalwire.web_admission import is_loopback


@record
class Settings:
    """The settings of a running bridge."""

    port: int
    host: str = '127.0.0.1'
    token: str = ''
    """'' lets everybody connect who reaches the port; allowed only on loopback."""
    tls_cert: str = ''
    tls_key: str = ''
    origins: tuple[str, ...] = ()
    """Sites whose pages may connect without a token, in addition to pages of this machine."""
    permissions: Permissions = Permissions()
    backlog: int = 10_000_000
    """Bytes that may wait for one client."""
    most_bytes: int = 64_000_000
    """The most bytes of one message from a client."""
    most_clients: int = 100
    call_timeout: float = 10.0
    """The time limit of a call, in s, if the client gives none."""
    keeps_goals: bool = False
    """True to let a lost client's goals go on; otherwise they are cancelled."""

    @property
    def is_loopback(self) -> bool:
        """True if only this machine can reach the bridge."""
        return is_loopback(self.host)

    def url(self, port: int) -> str:
        """Return the address for clients on this machine, with the token if there is one."""
        host = 'localhost' if self.host in {'127.0.0.1', '0.0.0.0', '::'} else self.host  # noqa: S104
        query = f'?token={self.token}' if self.token else ''
        scheme = 'wss' if self.tls_cert else 'ws'
        return f'{scheme}://{f"[{host}]" if ":" in host else host}:{port}/{query}'
