"""Settings of the console: the page's address, who may look, and the names to which it may send."""

from __future__ import annotations

from fnmatch import fnmatchcase

from goalwire.apps.console.addresses import addresses_on_networks, is_every_interface
from goalwire.errors import NotAllowedError
from goalwire.records import record
from goalwire.web_admission import is_loopback

DEFAULT_PORT = 8420
VIEWS = (
    'robot', 'missions', 'actions', 'services', 'topics', 'parameters', 'graph', 'logs', 'record',
    'statistics',
)  # fmt: skip
"""The views that an address may name."""


@record
class Settings:
    """The settings of a running console."""

    host: str = '127.0.0.1'
    port: int = DEFAULT_PORT
    token: str = ''
    """'' lets everybody look who reaches the port; allowed only on loopback."""
    tls_cert: str = ''
    tls_key: str = ''
    read_only: bool = False
    allow: tuple[str, ...] = ()
    """Patterns of the names to which the page may send; without patterns it may send to all names."""
    takes_any_port: bool = False
    """True to use any free port if `port` is taken."""
    record_to: str = '.'
    """The folder in which the page makes bags."""
    view: str = ''
    """The view that opens first; '' leaves the choice to the page."""
    missions: str = ''
    """The journal of missions to show; '' shows none."""

    @property
    def is_loopback(self) -> bool:
        """True if only this machine can reach the page."""
        return is_loopback(self.host)

    @property
    def scheme(self) -> str:
        """The scheme of the page's address."""
        return 'https' if self.tls_cert else 'http'

    def urls(self, port: int) -> list[str]:
        """Return the addresses to open, with the token if there is one: the first is for this machine.

        More follow if the page is served on all interfaces.
        """
        if is_every_interface(self.host):
            hosts = ['localhost', *addresses_on_networks(self.host)]
        else:
            hosts = ['localhost' if self.host == '127.0.0.1' else self.host]
        named = {'token': self.token, 'view': self.view}
        query = '&'.join(f'{name}={value}' for name, value in named.items() if value)
        end = f'{port}/{query and f"?{query}"}'
        return [f'{self.scheme}://{f"[{host}]" if ":" in host else host}:{end}' for host in hosts]

    def check_may_send(self, name: str) -> None:
        """Raise NotAllowedError if the console may not send to that topic, service, action or node."""
        if self.read_only:
            raise NotAllowedError('this console is read-only (--read-only): nothing was sent')
        if self.allow and not any(fnmatchcase(name, pattern) for pattern in self.allow):
            raise NotAllowedError(
                f"this console may not send to '{name}' (--allow {' --allow '.join(self.allow)}): "
                'nothing was sent'
            )

    def check_may_record(self) -> None:
        """Raise NotAllowedError if the console may not record: that fills the disk of its machine."""
        if self.read_only:
            raise NotAllowedError('this console is read-only (--read-only): it does not record')

    def may_send(self, name: str) -> bool:
        """Return True if `check_may_send` raises no error."""
        try:
            self.check_may_send(name)
        except NotAllowedError:
            return False
        return True
