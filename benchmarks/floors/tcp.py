"""The floor of all: bytes to another Python process and back over TCP, read as soon as `poll` says so.

Nothing is named, numbered or decoded. Each message is bytes of its own, as a subscriber needs it. The work
`asyncio` has a transport and a protocol of asyncio's at either end.
"""

from __future__ import annotations

import asyncio
import select
import socket
import struct
from collections.abc import Callable
from threading import Thread
from time import perf_counter

from benchmarks import stage
from benchmarks.line import Figures

SIZE = 64
MESSAGE = bytes(SIZE)
IMAGE_SIZE = 1_000_000
READ_SIZE = 65536
CLOCK = struct.Struct('d')


class Connection:
    """A connected socket that is waited for."""

    def __init__(self, sock: socket.socket) -> None:
        sock.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
        poll = select.poll()
        poll.register(sock, select.POLLIN)
        self._wait = poll.poll
        self._recv = sock.recv
        self.send = sock.sendall

    def some(self) -> bytes:
        """Wait for bytes; none if the other end has closed."""
        self._wait()
        return self._recv(READ_SIZE)

    def message(self, size: int = SIZE) -> bytes:
        """Wait for a message; empty where the other end has closed."""
        first = self.some()
        if len(first) == size or not first:
            return first
        parts, left = [first], size - len(first)
        while left and (part := self.some()):
            parts.append(part)
            left -= len(part)
        return b'' if left else b''.join(parts)


def answer(port: int, work: str, size: int) -> None:
    """Do the other half of one work until the asking process ends."""
    with socket.create_connection(('127.0.0.1', port)) as sock:
        connection = Connection(sock)

        def send(count: int) -> None:
            for _ in range(count):
                connection.send(MESSAGE)

        if work == 'throughput':
            stage.obey({'send': send})
            return
        thread = Thread(target=stage.obey, args=({},))
        thread.start()
        if work == 'asyncio':
            asyncio.run(echo_by_asyncio(sock))
        elif work == 'image':
            while connection.message(size):
                connection.send(CLOCK.pack(perf_counter()))
        else:
            while message := connection.message():
                connection.send(message)
        thread.join()


class Protocol(asyncio.Protocol):
    """Hands what comes to a function; messages are short, so each comes in one."""

    def __init__(self, take: Callable[[bytes], object], closed: Callable[[], object] = bool) -> None:
        self._take = take
        self._closed = closed

    def data_received(self, data: bytes) -> None:
        self._take(data)

    def connection_lost(self, exc: Exception | None) -> None:  # noqa: ARG002 - asyncio's
        self._closed()


async def echo_by_asyncio(sock: socket.socket) -> None:
    """Send everything back until the other end has closed."""
    loop = asyncio.get_running_loop()
    ended = asyncio.Event()
    protocol = Protocol(lambda data: transport.write(data), ended.set)  # noqa: PLW0108 - made below
    transport, _ = await loop.create_connection(lambda: protocol, sock=sock)
    await ended.wait()


def round_trip(sock: socket.socket, count: int, partner: stage.Partner) -> Figures:
    """Send a message and wait until it is back: what a call and a topic's round trip have in common."""
    connection = Connection(sock)

    def exchange() -> None:
        connection.send(MESSAGE)
        connection.message()

    return stage.round_trips(exchange, count, partner)


def asyncio_calls(sock: socket.socket, count: int, partner: stage.Partner) -> Figures:
    """Await a future, which the protocol settles."""

    async def measure() -> Figures:
        loop = asyncio.get_running_loop()
        waiting: list[asyncio.Future[bytes]] = []
        transport, _ = await loop.create_connection(
            lambda: Protocol(lambda data: waiting.pop().set_result(data)), sock=sock
        )

        async def call() -> None:
            future = loop.create_future()
            waiting.append(future)
            transport.write(MESSAGE)
            await future

        figures = await stage.awaited(call, count, partner)
        transport.close()
        return figures

    return asyncio.run(measure())


def throughput(sock: socket.socket, count: int, partner: stage.Partner) -> Figures:
    """Take messages that are sent one by one, as fast as one thread can."""
    connection = Connection(sock)
    arrivals: list[float] = []
    meter = stage.Meter(partner)
    partner.order('send', count)
    tail = b''
    while len(arrivals) < count:
        data = tail + connection.some()
        whole = len(data) - len(data) % SIZE
        for at in range(0, whole, SIZE):
            data[at : at + SIZE]
            arrivals.append(perf_counter())
        tail = data[whole:]
    partner.result()
    return meter.read(count) | {'rate': (count - 1) / (arrivals[-1] - arrivals[0])}


def image(sock: socket.socket, count: int, partner: stage.Partner, size: int = IMAGE_SIZE) -> Figures:
    """Send a megabyte; the partner says when it had it."""
    connection = Connection(sock)
    payload = bytes(size)

    def send() -> float:
        begun = perf_counter()
        connection.send(payload)
        seen: float = CLOCK.unpack(connection.message(CLOCK.size))[0]
        return seen - begun

    return stage.reported(send, count, partner)


WORKS: dict[str, Callable[..., Figures]] = {
    'service': round_trip,
    'topic': round_trip,
    'asyncio': asyncio_calls,
    'throughput': throughput,
    'image': image,
}


def ask(work: str, count: int, size: int = IMAGE_SIZE) -> Figures:
    with socket.create_server(('127.0.0.1', 0)) as listener:
        port = listener.getsockname()[1]
        with stage.Partner('benchmarks.floors.tcp', port, work, size) as partner:
            sock, _ = listener.accept()
            with sock:
                return WORKS[work](sock, count, partner, *([size] if work == 'image' else []))


if __name__ == '__main__':
    stage.run(ask, answer)
