"""The sockets on which a session listens for others."""

from __future__ import annotations

import socket
from collections.abc import Callable
from errno import EADDRINUSE

from goalwire.concurrency.forks import open_privately
from goalwire.concurrency.poller import IN, Poller
from goalwire.errors import AddressTakenError, TransportError
from goalwire.zenoh.io.endpoints import Endpoint, locators_of, resolve

AGAIN_S = 1.0
"""The pause in accepting connections after this process has run out of file descriptors."""


class Listeners:
    """The listening sockets of one session. The thread that reads accepts their connections."""

    def __init__(
        self, poller: Poller, take: Callable[[socket.socket, str], None], warn: Callable[[str], None]
    ) -> None:
        """`take` gets each connected socket, and 'tcp' or 'tls'."""
        self._poller = poller
        self._take = take
        self._warn = warn
        self._sockets: list[socket.socket] = []
        self._is_closed = False

    def listen(self, endpoint: Endpoint, text: str) -> list[str]:
        """Listen at an address and return the addresses at which others reach it.

        `text` is the address for error messages. Raises TransportError, AddressTakenError among them.
        """
        try:
            family, address = resolve(endpoint, passive=True)[0]
            # [::] means every address of this machine, IPv4 included; Python would listen on IPv6 only.
            is_any = address[0] == '::' and socket.has_dualstack_ipv6()
            listener = open_privately(
                lambda: socket.create_server(address[:2], family=family, backlog=128, dualstack_ipv6=is_any)
            )
        except OSError as error:
            kind = AddressTakenError if error.errno == EADDRINUSE else TransportError
            raise kind(f"cannot listen on '{text}': {error.strerror or error}") from None
        listener.setblocking(False)
        self._sockets.append(listener)
        self._watch(listener, endpoint.protocol)
        return locators_of(listener, endpoint.protocol)

    def _watch(self, listener: socket.socket, protocol: str) -> None:
        self._poller.register(listener.fileno(), IN, lambda _: self._accept(listener, protocol))

    def _accept(self, listener: socket.socket, protocol: str) -> None:
        while not self._is_closed:
            try:
                sock = open_privately(lambda: listener.accept()[0])
            except (BlockingIOError, InterruptedError, ConnectionAbortedError):
                return
            except OSError as error:  # too many open files: some may be closed soon
                self._warn(f'no connection can be taken: {error.strerror}; tried again each second')
                self._poller.unregister(listener.fileno())
                self._poller.call_later(AGAIN_S, lambda: self._accept_again(listener, protocol))
                return
            self._take(sock, protocol)

    def _accept_again(self, listener: socket.socket, protocol: str) -> None:
        if not self._is_closed:
            self._watch(listener, protocol)

    def stop(self) -> None:
        """Stop accepting; the sockets stay open until `close`."""
        self._is_closed = True

    def close(self) -> None:
        """Close the listening sockets. Accepted connections stay open."""
        self._is_closed = True
        for listener in self._sockets:
            self._poller.unregister(listener.fileno())
            listener.close()
