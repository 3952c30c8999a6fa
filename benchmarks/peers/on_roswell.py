"""The works on roswell: asyncio where the package is asynchronous, on DDS by Rust.

usage: python -m benchmarks.peers.on_roswell ask WORK COUNT | answer WORK | first
"""

from time import perf_counter

BEGUN = perf_counter()

import asyncio  # noqa: E402
import itertools  # noqa: E402
import os  # noqa: E402
import sys  # noqa: E402
from contextlib import suppress  # noqa: E402
from pathlib import Path  # noqa: E402
from typing import TYPE_CHECKING, Any  # noqa: E402

import roswell  # type: ignore[import-not-found]  # noqa: E402

if TYPE_CHECKING:
    from benchmarks import stage
    from benchmarks.line import Figures

ME = 'benchmarks.peers.on_roswell'
DEFINITIONS = Path(__file__).resolve().parents[2] / 'src' / 'goalwire' / 'idl' / 'share'
SERVICE, ACTION, PING, PONG = '/bench_switch', '/bench_count', '/bench_ping', '/bench_pong'
POSE, SWITCH, COUNT = (
    'geometry_msgs/msg/PoseStamped',
    'std_srvs/srv/SetBool',
    'example_interfaces/action/Fibonacci',
)
DEEP = roswell.QosProfile(depth=10)
PATIENCE_S = 20.0
FIRST_S = 0.05
"""How long a request waits that the server may not have got."""


def new_node(name: str) -> Any:
    return roswell.Node(name, domain=int(os.environ['ROS_DOMAIN_ID']), type_paths=[DEFINITIONS])


async def send_back(node: Any) -> None:
    pose = node.load_type(POSE)
    pong = node.publisher(PONG, pose, qos=DEEP)
    async with node.subscribe(PING, pose, qos=DEEP) as pings:
        async for message in pings:
            pong.publish(message)


def answer(work: str) -> None:
    """Do the other half of a work until the asking process ends."""
    from benchmarks import stage

    node = new_node('bench_server')
    if work == 'topic':

        async def main() -> None:
            half = asyncio.create_task(send_back(node))
            await asyncio.to_thread(stage.obey, {})
            half.cancel()

        asyncio.run(main())
        os._exit(0)  # a loop of Rust holds the interpreter
    types = node.load_service(SWITCH)

    def switch(request: Any) -> Any:
        response = types[1].alloc()
        response.success, response.message = request.data, 'switched'
        return response

    def count(_goal: Any, handle: Any) -> Any:
        result = handle.new_result()
        result.sequence = [0, 1]
        return result

    kept = (
        node.action_server(ACTION, COUNT, count) if work == 'action' else node.serve(SERVICE, types, switch)
    )
    stage.obey({})
    del kept
    os._exit(0)


def prepare_service(node: Any) -> Any:
    """Return a function that calls the service."""
    client = node.client(SERVICE, *node.load_service(SWITCH))

    def call(timeout: float = PATIENCE_S) -> None:
        request = client.new_request()
        request.data = True
        assert client.call_sync(request, timeout=timeout).success

    end = perf_counter() + PATIENCE_S
    while perf_counter() < end:  # it cannot wait for a service, and loses a request that comes too early
        with suppress(roswell.RoswellTimeout):
            call(FIRST_S)
            break
    return call


def prepare_action(node: Any) -> Any:
    """Return a function that sends a goal and waits for its result."""
    client = node.action_client(ACTION, COUNT)
    client.wait_for_server(PATIENCE_S)

    def reach() -> None:
        goal = client.new_goal()
        goal.order = 1
        goal_id, is_accepted = client.send_goal_sync(goal, timeout=PATIENCE_S)
        assert is_accepted
        _, result = client.get_result_sync(goal_id, timeout=PATIENCE_S)
        assert len(result.sequence) == 2

    return reach


async def go_round(node: Any, count: int, partner: 'stage.Partner') -> 'Figures':
    from benchmarks import stage

    pose = node.load_type(POSE)
    ping = node.publisher(PING, pose, qos=DEEP)
    async with node.subscribe(PONG, pose, qos=DEEP) as pongs:
        arrived, numbers = aiter(pongs), itertools.count()

        async def exchange() -> None:
            message = ping.new()
            message.header.frame_id = sent = str(next(numbers))
            ping.publish(message)
            while (await anext(arrived)).header.frame_id != sent:
                pass  # of the meeting

        first = asyncio.ensure_future(anext(arrived))
        while not first.done():  # until both ends have found each other
            ping.publish(ping.new())
            await asyncio.wait([first], timeout=0.1)
        return await stage.awaited(exchange, count, partner)


def ask(work: str, count: int) -> 'Figures':
    """Measure a work."""
    from benchmarks import stage
    from benchmarks.peers import first_answer

    with stage.Partner(ME, work) as partner:
        if work == 'start':
            return first_answer.measure(ME, count)
        node = new_node('bench_client')
        if work == 'topic':
            return asyncio.run(go_round(node, count, partner))
        return stage.round_trips(
            (prepare_action if work == 'action' else prepare_service)(node), count, partner
        )


def first() -> None:
    from benchmarks.peers import first_answer

    prepare_service(new_node('bench_client'))
    first_answer.tell(BEGUN)
    os._exit(0)


if __name__ == '__main__':
    if sys.argv[1] == 'first':
        first()
    else:
        from benchmarks import stage

        stage.run(ask, answer)
