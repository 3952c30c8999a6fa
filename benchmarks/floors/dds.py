"""The floor on DDS: the same works with libddsc alone, each side on one thread in a waitset."""

from __future__ import annotations

import asyncio
import struct
from collections.abc import Callable
from threading import Thread
from time import perf_counter

from benchmarks import stage
from benchmarks.line import Figures
from benchmarks.wire_dds import PATIENCE_NS, End

FOREVER_NS = 2**63 - 1
HEADER = b'\0\1\0\0'
MESSAGE = HEADER + bytes(76)
"""64 bytes and a service's header."""
IMAGE_SIZE = 1_000_000
CLOCK = struct.Struct('d')


def answer(work: str) -> None:
    """Do the other half of one work until the asking process ends."""
    end = End('rt/raw_pong', 'rt/raw_ping')
    if work == 'throughput':
        stage.obey({'send': lambda count: send(end, count)})
        return
    Thread(target={'image': view}.get(work, echo), args=(end,), daemon=True).start()
    stage.obey({})


def send(end: End, count: int) -> None:
    """Send as fast as it goes."""
    end.meet()
    for _ in range(count):
        end.write(MESSAGE)


def echo(end: End) -> None:
    """Send every message back."""
    end.meet()
    while True:
        for message in end.take(FOREVER_NS):
            end.write(message)


def view(end: End) -> None:
    """Say when each message was there."""
    end.meet()
    while True:
        for _message in end.take(FOREVER_NS):
            end.write(HEADER + CLOCK.pack(perf_counter()))


def round_trip(end: End, count: int, partner: stage.Partner) -> Figures:
    """Send a message and wait until it is back: what a call and a topic's round trip have in common."""

    def exchange() -> None:
        end.write(MESSAGE)
        assert end.take(PATIENCE_NS), 'the raw echo did not come'

    return stage.round_trips(exchange, count, partner)


def asyncio_calls(end: End, count: int, partner: stage.Partner) -> Figures:
    """Await a future of the loop, which a thread in the waitset settles."""

    async def measure() -> Figures:
        loop = asyncio.get_running_loop()
        waiting: list[asyncio.Future[bytes]] = []

        def receive() -> None:
            for _ in range(stage.WARM_UP + count):
                (message,) = end.take(PATIENCE_NS)
                loop.call_soon_threadsafe(waiting.pop().set_result, message)

        async def call() -> None:
            future = loop.create_future()
            waiting.append(future)
            end.write(MESSAGE)
            await future

        thread = Thread(target=receive)
        thread.start()
        figures = await stage.awaited(call, count, partner)
        thread.join()
        return figures

    return asyncio.run(measure())


def throughput(end: End, count: int, partner: stage.Partner) -> Figures:
    """Take messages that are sent as fast as one thread can."""
    meter = stage.Meter(partner)
    partner.order('send', count)
    arrived = len(end.take(PATIENCE_NS))
    begun, last = perf_counter(), perf_counter()
    taken = arrived
    while taken < count:
        taken += len(end.take(PATIENCE_NS))
        last = perf_counter()
    partner.result()
    return meter.read(taken) | {'rate': (taken - arrived) / (last - begun)}


def image(end: End, count: int, partner: stage.Partner, size: int = IMAGE_SIZE) -> Figures:
    """Send a megabyte; the partner says when it had it."""
    payload = HEADER + bytes(size)

    def send_one() -> float:
        begun = perf_counter()
        end.write(payload)
        (message,) = end.take(PATIENCE_NS)
        seen: float = CLOCK.unpack(message[len(HEADER) :][: CLOCK.size])[0]
        return seen - begun

    return stage.reported(send_one, count, partner)


WORKS: dict[str, Callable[..., Figures]] = {
    'service': round_trip,
    'topic': round_trip,
    'asyncio': asyncio_calls,
    'throughput': throughput,
    'image': image,
}


def ask(work: str, count: int, *options: int) -> Figures:
    with stage.Partner('benchmarks.floors.dds', work) as partner:
        end = End('rt/raw_ping', 'rt/raw_pong')
        if work != 'throughput':
            end.meet()
        figures = WORKS[work](end, count, partner, *options)
        end.close()
        return figures


if __name__ == '__main__':
    stage.run(ask, answer)
