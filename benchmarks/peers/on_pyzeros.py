"""The works on pyzeros: an asyncio program, whose two processes meet without a router.

usage: python -m benchmarks.peers.on_pyzeros ask WORK COUNT | answer WORK PORT | first PORT
"""

from time import perf_counter

BEGUN = perf_counter()

import asyncio  # noqa: E402
import itertools  # noqa: E402
import json  # noqa: E402
import sys  # noqa: E402
from collections.abc import Coroutine  # noqa: E402
from typing import TYPE_CHECKING, Any  # noqa: E402

import zenoh  # noqa: E402
from asyncio_for_robotics import Scope  # type: ignore[import-not-found]  # noqa: E402
from pyzeros import Client, Pub, Server, Sub, auto_context  # type: ignore[import-not-found]  # noqa: E402
from ros2_pyterfaces.cyclone.all_msgs import PoseStamped  # type: ignore[import-not-found]  # noqa: E402
from ros2_pyterfaces.cyclone.all_srvs import SetBool  # type: ignore[import-not-found]  # noqa: E402

if TYPE_CHECKING:
    from benchmarks import stage
    from benchmarks.line import Figures

ME = 'benchmarks.peers.on_pyzeros'
SERVICE, PING, PONG = 'bench_switch', 'bench_ping', 'bench_pong'


def run(main: Coroutine[Any, Any, Any], name: str, *, listen: int = 0, connect: int = 0) -> Any:
    """Run a coroutine on a session that listens at one port, or connects to it."""
    config = zenoh.Config()
    config.insert_json5('scouting/multicast/enabled', 'false')
    for key, port in (('listen', listen), ('connect', connect)):
        config.insert_json5(f'{key}/endpoints', json.dumps([f'tcp/127.0.0.1:{port}'] if port else []))

    async def scoped() -> Any:
        async with Scope():
            return await main

    with zenoh.open(config) as session, auto_context(name, session, namespace='/'):
        return asyncio.run(scoped())


async def serve() -> None:
    server = Server(SetBool, SERVICE)
    async for responder in server.listen_reliable():
        responder.response.success = responder.request.data
        responder.response.message = 'switched'
        responder.send()


async def send_back() -> None:
    heard, said = Sub(PoseStamped, PING), Pub(PoseStamped, PONG)
    async for pose in heard.listen_reliable():
        said.publish(pose)


def answer(work: str, port: int) -> None:
    """Do the other half of a work until the asking process ends."""
    from benchmarks import stage

    async def main() -> None:
        half = asyncio.create_task(send_back() if work == 'topic' else serve())
        await asyncio.sleep(0)
        await asyncio.to_thread(stage.obey, {})
        half.cancel()

    run(main(), 'bench_server', listen=port)


async def call_services(count: int, partner: 'stage.Partner') -> 'Figures':
    from benchmarks import stage

    client = Client(SetBool, SERVICE)
    await client.wait_for_service()

    async def call() -> None:
        response = await client.call_async(SetBool.Request(data=True))
        assert response.success

    return await stage.awaited(call, count, partner)


async def go_round(count: int, partner: 'stage.Partner') -> 'Figures':
    from benchmarks import stage

    heard, said = Sub(PoseStamped, PONG), Pub(PoseStamped, PING)
    pose = PoseStamped()
    arrived, numbers = heard.listen_reliable(), itertools.count()

    async def exchange() -> None:
        pose.header.frame_id = sent = str(next(numbers))
        said.publish(pose)
        while (await anext(arrived)).header.frame_id != sent:
            pass  # of the meeting

    first = asyncio.ensure_future(anext(arrived))
    while not first.done():  # until both ends have found each other
        said.publish(pose)
        await asyncio.wait([first], timeout=0.1)
    return await stage.awaited(exchange, count, partner)


def ask(work: str, count: int) -> 'Figures':
    """Measure a work."""
    from helpers.isolation import free_port

    from benchmarks import stage
    from benchmarks.peers import first_answer

    port = free_port()
    with stage.Partner(ME, work, port) as partner:
        if work == 'start':
            return first_answer.measure(ME, count, port)
        measured = (go_round if work == 'topic' else call_services)(count, partner)
        figures: Figures = run(measured, 'bench_client', connect=port)
        return figures


async def call_once() -> None:
    from benchmarks.peers import first_answer

    client = Client(SetBool, SERVICE)
    await client.wait_for_service()
    response = await client.call_async(SetBool.Request(data=True))
    assert response.success
    first_answer.tell(BEGUN)


if __name__ == '__main__':
    if sys.argv[1] == 'first':
        run(call_once(), 'bench_client', connect=int(sys.argv[2]))
    else:
        from benchmarks import stage

        stage.run(ask, answer)
