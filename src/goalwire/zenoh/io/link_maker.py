"""Makes the link of a connected socket: plain, or with TLS on it."""

from __future__ import annotations

import socket
from typing import TYPE_CHECKING

from goalwire.concurrency.poller import Poller
from goalwire.errors import TransportError
from goalwire.zenoh.io.endpoints import Endpoint, TlsFiles
from goalwire.zenoh.io.identities import Identify
from goalwire.zenoh.io.socket_link import SocketLink, SocketLinkOwner
from goalwire.zenoh.protocol.handshake import Handshake

if TYPE_CHECKING:
    from goalwire.zenoh.io.tls import Tls


class LinkMaker:
    """Makes the links of one session's connections."""

    def __init__(
        self, owner: SocketLinkOwner, poller: Poller, files: TlsFiles, identify: Identify | None
    ) -> None:
        """With `identify` all links must have TLS; it identifies the other side by its certificate."""
        self._owner = owner
        self._poller = poller
        self._files = files
        self._identify = identify
        self._tls: Tls | None = None

    def check_listening(self, endpoint: Endpoint) -> None:
        """Raise TransportError if TLS is asked for, and its files cannot be used."""
        self._check_protocol(endpoint)
        if endpoint.protocol == 'tls':
            self._secured().check_listening()

    def check_dialling(self, endpoint: Endpoint) -> None:
        """Raise TransportError if TLS is asked for, and its files cannot be used."""
        self._check_protocol(endpoint)
        if endpoint.protocol == 'tls':
            self._secured().check_dialling()

    def _check_protocol(self, endpoint: Endpoint) -> None:
        """Refuse addresses without TLS if security is on: certificates identify the other side."""
        if self._identify is not None and endpoint.protocol != 'tls':
            raise TransportError(
                f'{endpoint.protocol}/{endpoint.host}:{endpoint.port} is not protected, and security is on: '
                f'write tls/{endpoint.host}:{endpoint.port}'
            )

    def make_inbound(self, sock: socket.socket, protocol: str, handshake: Handshake) -> SocketLink:
        """Return the link of a connection that another side has opened."""
        if protocol == 'tls':
            return self._refreshed().make_inbound(self._owner, sock, handshake, self._poller)
        return SocketLink(self._owner, sock, handshake, self._poller)

    def make_outbound(self, sock: socket.socket, endpoint: Endpoint, handshake: Handshake) -> SocketLink:
        """Return the link of a connection that was opened to an address."""
        if endpoint.protocol == 'tls':
            return self._refreshed().make_outbound(self._owner, sock, handshake, self._poller, endpoint.host)
        return SocketLink(self._owner, sock, handshake, self._poller)

    def _secured(self) -> Tls:
        """Return the session's TLS.

        The module is imported when it is first needed, which costs some 10 ms.
        """
        if self._tls is None:
            from goalwire.zenoh.io.tls import Tls

            self._tls = Tls(self._files, self._identify)
        return self._tls

    def _refreshed(self) -> Tls:
        """Return the session's TLS after reading certificate files that have changed."""
        tls = self._secured()
        try:
            tls.refresh()
        except TransportError as error:
            self._owner.refuse('renewed certificate', error)
        return tls
