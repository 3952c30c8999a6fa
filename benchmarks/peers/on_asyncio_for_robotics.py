"""The works on asyncio-for-robotics over the real rclpy: awaited calls, topics as streams.

usage: python -m benchmarks.peers.on_asyncio_for_robotics ask WORK COUNT | answer WORK | first
"""

from time import perf_counter

BEGUN = perf_counter()

import asyncio  # noqa: E402
import itertools  # noqa: E402
import os  # noqa: E402
import sys  # noqa: E402
from collections.abc import Coroutine  # noqa: E402
from typing import TYPE_CHECKING, Any  # noqa: E402

import asyncio_for_robotics.ros2 as afor  # type: ignore[import-not-found]  # noqa: E402
import rclpy  # noqa: E402
from geometry_msgs.msg import PoseStamped  # noqa: E402
from std_srvs.srv import SetBool  # noqa: E402

if TYPE_CHECKING:
    from rclpy.publisher import Publisher

    from benchmarks import stage
    from benchmarks.line import Figures

ME = 'benchmarks.peers.on_asyncio_for_robotics'
SERVICE, PING, PONG = 'bench_switch', 'bench_ping', 'bench_pong'


def run(main: Coroutine[Any, Any, Any]) -> Any:
    """Run a coroutine beside a session, as the package's examples do."""
    rclpy.init()
    try:
        return asyncio.run(main)
    finally:
        afor.auto_session().close()
        rclpy.shutdown()


def publisher(topic: str) -> 'Publisher[PoseStamped]':
    with afor.auto_session().lock() as node:
        made: Publisher[PoseStamped] = node.create_publisher(PoseStamped, topic, 10)
    return made


async def serve() -> None:
    server = afor.Server(SetBool, SERVICE)
    async for responder in server.listen_reliable():
        responder.response.success = responder.request.data
        responder.response.message = 'switched'
        responder.send()


async def send_back() -> None:
    heard, said = afor.Sub(PoseStamped, PING), publisher(PONG)
    async for pose in heard.listen_reliable():
        said.publish(pose)


def answer(work: str) -> None:
    """Do the other half of a work until the asking process ends."""
    from benchmarks import stage

    async def main() -> None:
        half = asyncio.create_task(send_back() if work == 'topic' else serve())
        await asyncio.sleep(0)
        await asyncio.to_thread(stage.obey, {})
        half.cancel()

    run(main())


async def call_services(count: int, partner: 'stage.Partner') -> 'Figures':
    from benchmarks import stage

    client = afor.Client(SetBool, SERVICE)
    await client.wait_for_service()

    async def call() -> None:
        response = await client.call(SetBool.Request(data=True))
        assert response.success

    return await stage.awaited(call, count, partner)


async def go_round(count: int, partner: 'stage.Partner') -> 'Figures':
    from benchmarks import stage

    heard, said = afor.Sub(PoseStamped, PONG), publisher(PING)
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
    from benchmarks import stage
    from benchmarks.peers import first_answer

    with stage.Partner(ME, work) as partner:
        if work == 'start':
            return first_answer.measure(ME, count)
        figures: Figures = run((go_round if work == 'topic' else call_services)(count, partner))
        return figures


async def call_once() -> None:
    from benchmarks.peers import first_answer

    client = afor.Client(SetBool, SERVICE)
    await client.wait_for_service()
    response = await client.call(SetBool.Request(data=True))
    assert response.success
    first_answer.tell(BEGUN)
    os._exit(0)  # the end of the process is not measured, and aborts at times


if __name__ == '__main__':
    if sys.argv[1] == 'first':
        run(call_once())
    else:
        from benchmarks import stage

        stage.run(ask, answer)
