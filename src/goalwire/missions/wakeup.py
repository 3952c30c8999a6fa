"""Wakes a runner that has commands waiting in its file: an empty datagram on loopback.

The commands are in the file; the datagram only means "read the file". So a false datagram does no harm, nor
does a lost one if no runner is there.
"""

from __future__ import annotations

import asyncio
import socket
from collections.abc import Callable
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from goalwire.missions.journal_store import Store

_LOOPBACK = '127.0.0.1'
_PORT = 'port'


class _Bell(asyncio.DatagramProtocol):
    def __init__(self, ring: Callable[[], object]) -> None:
        self._ring = ring

    def datagram_received(self, data: bytes, addr: object) -> None:  # noqa: ARG002
        self._ring()


async def hang_bell(ring: Callable[[], object]) -> tuple[asyncio.DatagramTransport, int]:
    """Call `ring` in the loop for each datagram; return the transport to close, and the port."""
    loop = asyncio.get_running_loop()
    transport, _ = await loop.create_datagram_endpoint(lambda: _Bell(ring), local_addr=(_LOOPBACK, 0))
    return transport, transport.get_extra_info('sockname')[1]


def note_port(store: Store, port: int) -> None:
    """Write on which port the runner listens; 0 when the runner ends."""
    store.set_fact(_PORT, str(port))


def wake_runner(store: Store) -> None:
    """Send a datagram to the runner of a file, if there is one."""
    port = store.fact(_PORT)
    if port not in {'', '0'}:
        with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as bell:
            bell.sendto(b'', (_LOOPBACK, int(port)))
