"""Notices when an interface of this host appears, disappears or changes its address."""

from __future__ import annotations

import socket
import sys
from collections.abc import Callable
from contextlib import suppress

from goalwire.concurrency.forks import open_privately
from goalwire.concurrency.poller import IN, Poller, Timer

_LINKS, _ADDRESSES_V4, _ADDRESSES_V6 = 0x1, 0x10, 0x100
"""Groups of rtnetlink, from linux/rtnetlink.h: RTMGRP_LINK, RTMGRP_IPV4_IFADDR, RTMGRP_IPV6_IFADDR."""
LOOK_S = 3.0
"""How often to look at the interfaces if the system does not report changes."""


class InterfaceChanges:
    """Calls a function after each change of an interface, on the thread that waits on a poller."""

    def __init__(self, poller: Poller, on_change: Callable[[], None]) -> None:
        """If the system cannot report changes, `on_change` is called every LOOK_S seconds."""
        self._poller = poller
        self._on_change = on_change
        self._timer: Timer | None = None
        self._socket = _subscribe()
        if self._socket is None:
            self._look_later()
        else:
            poller.register(self._socket.fileno(), IN, self._read)

    def _read(self, _events: int) -> None:
        assert self._socket is not None
        with suppress(OSError):  # raised if the socket is empty or has overflowed
            while self._socket.recv(65536):
                pass
        self._on_change()

    def _look_later(self) -> None:
        self._timer = self._poller.call_later(LOOK_S, self._look)

    def _look(self) -> None:
        self._look_later()
        self._on_change()

    def close(self) -> None:
        """Stop watching. The poller must be closed already, or be closed by the same thread afterwards."""
        if self._timer is not None:
            self._timer.cancel()
        if self._socket is not None:
            self._socket.close()


def _subscribe() -> socket.socket | None:
    """Return a socket that is readable after each change of an interface; None if it cannot be opened."""
    if sys.platform != 'linux':
        return None
    try:
        sock = open_privately(lambda: socket.socket(socket.AF_NETLINK, socket.SOCK_RAW, socket.NETLINK_ROUTE))
    except OSError:  # a sandbox may forbid netlink sockets
        return None
    try:
        sock.setblocking(False)
        sock.bind((0, _LINKS | _ADDRESSES_V4 | _ADDRESSES_V6))
    except OSError:
        sock.close()
        return None
    return sock
