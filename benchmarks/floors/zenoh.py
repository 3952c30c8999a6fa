"""The floor on eclipse-zenoh: the same works without goalwire, answered on Zenoh's own thread.

Decodes nothing. Runs with the thread settings that goalwire gives Zenoh.
"""

from __future__ import annotations

import asyncio
import json
import struct
import sys
from collections.abc import Callable
from threading import Event, Lock
from time import perf_counter
from typing import Any

import zenoh
from helpers.isolation import free_port

from benchmarks import spinning, stage
from benchmarks.line import Figures
from goalwire.transport.zenoh import threads
from goalwire.transport.zenoh.settings import built_in
from goalwire.transport.zenoh.threads import keep_thread_state

PAYLOAD = bytes(64)
ATTACHMENT = bytes(33)
SERVICE, PING, PONG, STREAM, IMAGE, SEEN = (
    f'raw/{name}' for name in ('service', 'ping', 'pong', 'stream', 'image', 'seen')
)
IMAGE_SIZE = 1_000_000
CLOCK = struct.Struct('d')


def open_session(*, listen: int = 0, connect: int = 0) -> zenoh.Session:
    """Open a session that returns once it is connected."""
    values = built_in.session(connect)
    values['connect'] = {
        'endpoints': [f'tcp/127.0.0.1:{connect}'] if connect else [],
        'timeout_ms': int(spinning.PATIENCE_S * 1000),
        'exit_on_failure': True,
    }
    values['listen'] = {'endpoints': [f'tcp/127.0.0.1:{listen}'] if listen else []}
    return threads.open_session(zenoh.Config.from_json5(json.dumps(values)))


def direct(callback: Callable[[Any], None]) -> Any:
    """Return a handler that calls back on Zenoh's thread."""
    return zenoh.handlers.Callback(callback, indirect=False)


def answer(port: int) -> None:
    """Do the other half of every work."""
    session = open_session(listen=port)
    pong, seen = session.declare_publisher(PONG), session.declare_publisher(SEEN)
    stream = session.declare_publisher(STREAM, congestion_control=zenoh.CongestionControl.BLOCK)

    def reply(query: zenoh.Query) -> None:
        keep_thread_state()
        assert query.payload is not None
        assert query.attachment is not None
        query.reply(SERVICE, query.payload.to_bytes(), attachment=query.attachment.to_bytes())
        query.drop()  # type: ignore[no-untyped-call]

    def send_back(sample: zenoh.Sample) -> None:
        keep_thread_state()
        assert sample.attachment is not None
        pong.put(sample.payload.to_bytes(), attachment=sample.attachment.to_bytes())

    def view(sample: zenoh.Sample) -> None:
        keep_thread_state()
        sample.payload.to_bytes()
        seen.put(CLOCK.pack(perf_counter()))

    def send(count: int) -> None:
        for _ in range(count):
            stream.put(PAYLOAD, attachment=ATTACHMENT)

    session.declare_queryable(SERVICE, direct(reply), complete=True)
    session.declare_subscriber(PING, direct(send_back))
    session.declare_subscriber(IMAGE, direct(view))
    stage.obey({'send': send})
    session.close()  # type: ignore[no-untyped-call]


class Parked:
    """A lock on which a waiting thread sleeps until Zenoh's thread wakes it."""

    def __init__(self) -> None:
        self._lock = Lock()
        self._lock.acquire()
        self.wake = self._lock.release

    def wait(self) -> None:
        """Return once woken."""
        if not self._lock.acquire(timeout=spinning.PATIENCE_S):
            sys.exit('the raw partner did not answer')


def meet(session: zenoh.Session) -> None:
    """Wait until the partner sees what was declared here: it shows in a query that comes back after it."""
    if not list(session.get(SERVICE, payload=PAYLOAD, attachment=ATTACHMENT)):
        sys.exit('the raw partner was not found')


def query(session: zenoh.Session, on_payload: Callable[[bytes], None]) -> Callable[[], None]:
    """Return a function that sends one query, whose answer comes to `on_payload` on Zenoh's thread."""
    querier = session.declare_querier(
        SERVICE,
        target=zenoh.QueryTarget.ALL_COMPLETE,
        consolidation=zenoh.ConsolidationMode.NONE,
        congestion_control=zenoh.CongestionControl.BLOCK,
    )

    def on_reply(reply: zenoh.Reply) -> None:
        keep_thread_state()
        assert reply.ok is not None
        on_payload(reply.ok.payload.to_bytes())

    def get() -> None:
        handler = zenoh.handlers.Callback(on_reply, drop=keep_thread_state, indirect=False)
        querier.get(handler, payload=PAYLOAD, attachment=ATTACHMENT)

    return get


def service(session: zenoh.Session, count: int, partner: stage.Partner) -> Figures:
    """Query, wait on a lock, one after the other."""
    parked = Parked()
    get = query(session, lambda _: parked.wake())
    meet(session)

    def call() -> None:
        get()
        parked.wait()

    return stage.round_trips(call, count, partner)


def asyncio_calls(session: zenoh.Session, count: int, partner: stage.Partner) -> Figures:
    """Query, await a future of the loop, one after the other."""

    async def measure() -> Figures:
        loop = asyncio.get_running_loop()
        waiting: list[asyncio.Future[bytes]] = []
        get = query(session, lambda payload: _settle(loop, waiting.pop(), payload))
        meet(session)

        async def call() -> None:
            future = loop.create_future()
            waiting.append(future)
            get()
            await future

        return await stage.awaited(call, count, partner)

    return asyncio.run(measure())


def _settle(loop: asyncio.AbstractEventLoop, future: asyncio.Future[bytes], payload: bytes) -> None:
    loop.call_soon_threadsafe(future.set_result, payload)


def topic(session: zenoh.Session, count: int, partner: stage.Partner) -> Figures:
    """Send a message, wait on a lock until it has come back."""
    parked = Parked()
    ping = session.declare_publisher(PING)

    def on_pong(sample: zenoh.Sample) -> None:
        keep_thread_state()
        sample.payload.to_bytes()
        parked.wake()

    def exchange() -> None:
        ping.put(PAYLOAD, attachment=ATTACHMENT)
        parked.wait()

    session.declare_subscriber(PONG, direct(on_pong))
    meet(session)
    return stage.round_trips(exchange, count, partner)


def throughput(session: zenoh.Session, count: int, partner: stage.Partner) -> Figures:
    """Take messages that are sent as fast as one thread can."""
    arrivals: list[float] = []
    ended = Event()

    def take(sample: zenoh.Sample) -> None:
        keep_thread_state()
        sample.payload.to_bytes()
        arrivals.append(perf_counter())
        if len(arrivals) == count:
            ended.set()

    session.declare_subscriber(STREAM, direct(take))
    meet(session)
    meter = stage.Meter(partner)
    partner.do('send', count)
    ended.wait(spinning.PATIENCE_S)
    return meter.read(len(arrivals)) | {'rate': (len(arrivals) - 1) / (arrivals[-1] - arrivals[0])}


def image(session: zenoh.Session, count: int, partner: stage.Partner, size: int = IMAGE_SIZE) -> Figures:
    """Send a megabyte; the partner says when it had it."""
    parked, seen = Parked(), [0.0]
    publisher = session.declare_publisher(IMAGE, congestion_control=zenoh.CongestionControl.BLOCK)
    payload = bytes(size)

    def on_seen(sample: zenoh.Sample) -> None:
        keep_thread_state()
        (seen[0],) = CLOCK.unpack(sample.payload.to_bytes())
        parked.wake()

    def send() -> float:
        begun = perf_counter()
        publisher.put(payload)
        parked.wait()
        return seen[0] - begun

    session.declare_subscriber(SEEN, direct(on_seen))
    meet(session)
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
    with stage.Partner('benchmarks.floors.zenoh', port) as partner:
        session = open_session(connect=port)
        figures = WORKS[work](session, count, partner, *options)
        session.close()  # type: ignore[no-untyped-call]
        return figures


if __name__ == '__main__':
    stage.run(ask, answer)
