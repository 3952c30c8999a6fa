"""The floor on goalwire's own Zenoh session: its queries and puts, with nothing of ROS above them.

Decodes nothing. The thread that waits for an answer reads the wire, as an executor does.
"""

from __future__ import annotations

import asyncio
import os
import struct
import sys
from _thread import allocate_lock
from collections.abc import Callable
from contextlib import suppress
from functools import partial
from threading import Thread, get_ident
from time import perf_counter

from helpers.isolation import free_port

from benchmarks import spinning, stage
from benchmarks.line import Figures
from goalwire.transport.zenoh.native_wire import NativeWire
from goalwire.transport.zenoh.wire import Message, OnAnswer
from goalwire.zenoh.io.settings import Settings
from goalwire.zenoh.protocol.incoming_queries import Query

PAYLOAD = bytes(64)
ATTACHMENT = bytes(33)
SERVICE, PING, PONG, STREAM, IMAGE, SEEN = (
    f'raw/{name}' for name in ('service', 'ping', 'pong', 'stream', 'image', 'seen')
)
IMAGE_SIZE = 1_000_000
CLOCK = struct.Struct('d')
TIME_NS = int(spinning.PATIENCE_S * 1e9)


def open_wire(*, listen: int = 0, connect: int = 0) -> NativeWire:
    """Open a session that returns once it is connected."""
    return NativeWire(
        Settings(
            listen=(f'tcp/127.0.0.1:{listen}',) if listen else (),
            connect=(f'tcp/127.0.0.1:{connect}',) if connect else (),
            must_connect=bool(connect),
            connecting_s=spinning.PATIENCE_S,
        )
    )


def nothing() -> None:
    """A query has ended."""


class Reader:
    """A thread that reads the wire until it has what it wants."""

    def __init__(self, wire: NativeWire) -> None:
        self.interrupt: Callable[[], None] | None = None
        self._poller = wire.session.wire_poller
        self._is_over = False
        self._gate = allocate_lock()
        self._gate.acquire()
        self.take_wake: Callable[[], bool] = partial(self._gate.acquire, False)

    def wait(self, timeout_ns: int | None = TIME_NS) -> None:
        """Read until somebody calls `end`; ends the program where that takes too long."""
        while not self._is_over:
            if not self._poller.wait(self, timeout_ns):
                sys.exit('the raw partner did not answer')
        self._is_over = False

    def wait_on_lock(self, timeout_ns: int | None = None) -> bool:
        """Sleep on the lock, where another thread reads."""
        if timeout_ns is None:
            return self._gate.acquire()
        if timeout_ns <= 0:
            return self._gate.acquire(blocking=False)
        return self._gate.acquire(timeout=timeout_ns / 1e9)

    def end(self) -> None:
        """End the wait. Any thread."""
        self._is_over = True
        self.wake()

    def wake(self) -> None:
        """Have it look again: to read, where another thread has done so until now. Any thread."""
        with suppress(RuntimeError):  # it is awake
            self._gate.release()
        interrupt = self.interrupt
        if interrupt is not None:
            interrupt()


def answer(port: int) -> None:
    """Do the other half of every work."""
    wire = open_wire(listen=port)
    pong = wire.declare_publisher(PONG, reliable=True, waits=False)
    seen = wire.declare_publisher(SEEN, reliable=True, waits=False)
    stream = wire.declare_publisher(STREAM, reliable=True, waits=True)

    def reply(query: Query) -> None:
        assert query.payload is not None
        query.answer(SERVICE, query.payload, query.attachment)

    def send(count: int) -> None:
        for _ in range(count):
            stream.put(PAYLOAD, attachment=ATTACHMENT)

    wire.declare_queryable(SERVICE, reply)
    wire.declare_subscriber(PING, lambda message: pong.put(message.payload, attachment=message.attachment))
    wire.declare_subscriber(IMAGE, lambda _: seen.put(CLOCK.pack(perf_counter())))
    reader = Reader(wire)

    def follow() -> None:
        stage.obey({'send': send})
        reader.end()

    thread = Thread(target=follow)
    thread.start()
    reader.wait(None)
    thread.join()
    wire.close()


def query(wire: NativeWire, on_answer: OnAnswer) -> Callable[[], None]:
    """Return a function that sends one query, whose answer comes to `on_answer` on the thread that reads."""
    querier = wire.declare_querier(SERVICE)

    def get() -> None:
        querier.ask(PAYLOAD, ATTACHMENT, on_answer, nothing, TIME_NS)

    return get


def meet(wire: NativeWire) -> None:
    """Wait until the partner knows what was declared here: it does once a query has come back."""
    reader = Reader(wire)
    query(wire, lambda _: reader.end())()
    reader.wait()


def service(wire: NativeWire, count: int, partner: stage.Partner) -> Figures:
    """Query and read until the answer is there, one after the other."""
    reader = Reader(wire)
    get = query(wire, lambda _: reader.end())
    meet(wire)

    def call() -> None:
        get()
        reader.wait()

    return stage.round_trips(call, count, partner)


def asyncio_calls(wire: NativeWire, count: int, partner: stage.Partner) -> Figures:
    """Query, await a future of the loop, which reads the wire."""
    meet(wire)

    async def measure() -> Figures:
        loop = asyncio.get_running_loop()
        waiting: list[asyncio.Future[object]] = []
        get = query(wire, lambda answer: waiting.pop().set_result(answer))

        async def call() -> None:
            future = loop.create_future()
            waiting.append(future)
            get()
            await future

        poller = wire.session.wire_poller
        fd = poller.attach_loop()
        if fd is None:
            sys.exit('an asyncio loop cannot read the wire here')
        loop.add_reader(fd, poller.serve_ready)
        figures = await stage.awaited(call, count, partner)
        loop.remove_reader(fd)
        os.close(fd)
        poller.detach_loop(get_ident())
        return figures

    return asyncio.run(measure())


def topic(wire: NativeWire, count: int, partner: stage.Partner) -> Figures:
    """Send a message and read until it has come back."""
    reader = Reader(wire)
    ping = wire.declare_publisher(PING, reliable=True, waits=False)
    wire.declare_subscriber(PONG, lambda _: reader.end())
    meet(wire)

    def exchange() -> None:
        ping.put(PAYLOAD, attachment=ATTACHMENT)
        reader.wait()

    return stage.round_trips(exchange, count, partner)


def throughput(wire: NativeWire, count: int, partner: stage.Partner) -> Figures:
    """Take messages that are sent as fast as one thread can."""
    reader = Reader(wire)
    arrivals: list[float] = []

    def take(_message: Message) -> None:
        arrivals.append(perf_counter())
        if len(arrivals) == count:
            reader.end()

    wire.declare_subscriber(STREAM, take)
    meet(wire)
    meter = stage.Meter(partner)
    partner.order('send', count)
    reader.wait()
    partner.result()
    return meter.read(count) | {'rate': (count - 1) / (arrivals[-1] - arrivals[0])}


def image(wire: NativeWire, count: int, partner: stage.Partner, size: int = IMAGE_SIZE) -> Figures:
    """Send a megabyte; the partner says when it had it."""
    reader, seen = Reader(wire), [0.0]
    publisher = wire.declare_publisher(IMAGE, reliable=True, waits=True)
    payload = bytes(size)

    def on_seen(message: Message) -> None:
        assert message.payload is not None
        (seen[0],) = CLOCK.unpack(message.payload)
        reader.end()

    def send() -> float:
        begun = perf_counter()
        publisher.put(payload)
        reader.wait()
        return seen[0] - begun

    wire.declare_subscriber(SEEN, on_seen)
    meet(wire)
    return stage.reported(send, count, partner)


WORKS: dict[str, Callable[..., Figures]] = {
    'service': service,
    'asyncio': asyncio_calls,
    'topic': topic,
    'throughput': throughput,
    'image': image,
}


def ask(work: str, count: int, *options: int) -> Figures:
    port = free_port()
    with stage.Partner('benchmarks.floors.native', port) as partner:
        wire = open_wire(connect=port)
        figures = WORKS[work](wire, count, partner, *options)
        wire.close()
        return figures


if __name__ == '__main__':
    stage.run(ask, answer)
