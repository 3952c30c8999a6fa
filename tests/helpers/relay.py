"""A TCP relay for a stream between two programs: late, stalled, deaf or mute, or cut off. Needs no rights.

Bytes of a stream cannot be lost or overtake each other, so these are the faults that there are.
"""

from __future__ import annotations

import socket
import threading
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from enum import Enum
from functools import partial

from goalwire.transport.faults.delay_queue import DelayQueue, RealTime
from goalwire.transport.faults.kinds import Kind, Path

_CHUNK = 65_536


class Way(Enum):
    """A direction of the stream."""

    TO_SERVER = 'to the server'
    TO_CLIENT = 'to the client'


class _Stream:
    """One direction of one connection: reads here, writes there."""

    def __init__(
        self, relay: Relay, number: int, way: Way, source: socket.socket, target: socket.socket
    ) -> None:
        self._relay = relay
        self._way = way
        self._source = source
        self._target = target
        self._path: Path = (Kind.MESSAGE, str(number), way.value, '')
        self._thread = threading.Thread(target=self._run, name='relay-stream')
        self._thread.start()

    def _run(self) -> None:
        while True:
            try:
                chunk = self._source.recv(_CHUNK)
            except OSError:
                chunk = b''
            self._relay.gates[self._way].wait()
            deliver = partial(self._write, chunk)
            self._relay.delay_queue.carry(
                self._path, int(self._relay.delay_s * 1e9), deliver, overtakes=False
            )
            if not chunk:
                return

    def _write(self, chunk: bytes) -> None:
        with suppress(OSError):
            if chunk:
                self._target.sendall(chunk)
            else:
                self._target.shutdown(socket.SHUT_WR)

    def join(self) -> None:
        self._thread.join()


class Relay:
    """Listens on `port` of this machine and passes on to `server_port`. Its faults may change at any time."""

    def __init__(self, port: int, server_port: int) -> None:
        self.port = port
        self.delay_s = 0.0
        self.delay_queue = DelayQueue(RealTime())
        self.gates = {way: threading.Event() for way in Way}
        self.release()
        self._server_port = server_port
        self._lock = threading.Lock()
        self._sockets: list[socket.socket] = []
        self._streams: list[_Stream] = []
        self._connections = 0
        self._is_refusing = self._is_closed = False
        self._listener = socket.create_server(('127.0.0.1', port))
        self._thread = threading.Thread(target=self._accept, name='relay')
        self._thread.start()

    # -- faults

    def stall(self, *ways: Way) -> None:
        """Hold everything up that goes these ways (both by default), and keep it."""
        for way in ways or Way:
            self.gates[way].clear()

    def release(self) -> None:
        """Let everything pass again, beginning with what was held up."""
        for gate in self.gates.values():
            gate.set()

    def cut(self) -> None:
        """Break every connection and accept no new one until `mend`."""
        self._is_refusing = True
        self._break()

    def mend(self) -> None:
        """Accept connections again."""
        self._is_refusing = False

    # -- the stream

    def _accept(self) -> None:
        while True:
            client, _ = self._listener.accept()
            if self._is_closed:
                client.close()
                return
            try:
                if self._is_refusing:
                    raise ConnectionRefusedError
                server = socket.create_connection(('127.0.0.1', self._server_port), timeout=5.0)
            except OSError:
                client.close()
                continue
            server.settimeout(None)
            self._connect(client, server)

    def _connect(self, client: socket.socket, server: socket.socket) -> None:
        with self._lock:
            self._connections += 1
            self._sockets += [client, server]
            self._streams += [
                _Stream(self, self._connections, Way.TO_SERVER, client, server),
                _Stream(self, self._connections, Way.TO_CLIENT, server, client),
            ]

    def _break(self) -> None:
        with self._lock:
            for each in self._sockets:
                with suppress(OSError):
                    each.shutdown(socket.SHUT_RDWR)

    def close(self) -> None:
        """End everything."""
        self._is_closed = True
        with socket.create_connection(('127.0.0.1', self.port)):
            self._thread.join()
        self.release()
        self._break()
        for stream in self._streams:
            stream.join()
        self.delay_queue.clear()
        for each in (self._listener, *self._sockets):
            each.close()


@contextmanager
def relay(port: int, server_port: int) -> Iterator[Relay]:
    """Run a relay for the length of a block."""
    running = Relay(port, server_port)
    try:
        yield running
    finally:
        running.close()
