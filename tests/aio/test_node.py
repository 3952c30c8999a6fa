"""goalwire.Node: its life, its context, and who it lives beside."""

from __future__ import annotations

import asyncio
from collections.abc import Iterator
from pathlib import Path

import pytest
from helpers.fresh import output_of
from helpers.loops import LOOPS, Play, run, turns
from helpers.patience import PATIENCE
from helpers.spinning import Spinner
from rcl_interfaces.srv import GetParameters
from rclpy.context import Context
from rclpy.executors import SingleThreadedExecutor
from rclpy.node import Node
from std_msgs.msg import String
from std_srvs.srv import SetBool, Trigger
from type_description_interfaces.srv import GetTypeDescription

import goalwire
from goalwire.aio.node import CONTEXTS
from goalwire.errors import ClosedError, InvalidNodeNameException, ShutDownError
from goalwire.idl import type_hash


@pytest.fixture
def context(isolated: dict[str, str]) -> Iterator[Context]:
    context = Context()
    context.init(args=[])
    yield context
    context.try_shutdown()


def test_importing_goalwire_stays_light_until_a_name_is_asked_for(tmp_path: Path) -> None:
    program = """
        import sys, goalwire
        heavy = {'asyncio', 'typing', 'goalwire.aio', 'goalwire.errors', 'numpy', 'yaml', 'rich', 'zenoh'}
        print(sorted(heavy & set(sys.modules)))
        print('Node' in dir(goalwire), hasattr(goalwire, 'Nothing'))
        goalwire.Node('name')
        print(sorted(heavy & set(sys.modules)))
        print('rclpy' in sys.modules)
    """
    assert output_of(program, cwd=tmp_path).splitlines() == [
        '[]',
        'True False',
        "['asyncio', 'goalwire.aio', 'goalwire.errors', 'typing']",
        'False',
    ]


def test_every_name_of_the_package_is_there() -> None:
    for name in goalwire._ORIGINS:
        assert getattr(goalwire, name).__name__ == name


def test_a_node_is_in_the_graph_from_the_beginning_to_the_end_of_its_block(play: Play) -> None:
    async def scenario() -> None:
        async with goalwire.Node('watcher') as watcher:
            graph = watcher.context.graph
            node = goalwire.Node('short', namespace='/ns')
            assert not graph.node_exists('short', '/ns')
            async with node:
                assert node.name == '/ns/short'
                assert node.logger.name == 'ns.short'
                assert graph.node_exists('short', '/ns')
                assert repr(node) == '<goalwire.Node short, open>'
            assert not graph.node_exists('short', '/ns')
            with pytest.raises(ClosedError, match="the node 'short' is open in its block alone"):
                node.publisher(String, 'chat')
            with pytest.raises(ClosedError, match='entered before'):
                await node.__aenter__()

    play(scenario)


def test_nodes_share_a_context_for_each_domain_which_ends_with_the_last(play: Play) -> None:
    async def scenario() -> None:
        async with goalwire.Node('one') as one:
            async with goalwire.Node('two') as two, goalwire.Node('far', domain=0) as far:
                assert one.context is two.context
                assert far.context is not one.context
                assert far.context.get_domain_id() == 0
                shared = one.context
            assert CONTEXTS.open == 1
            assert shared.ok()
        assert not shared.ok()

    play(scenario)


def test_a_node_may_live_in_a_context_of_the_programs_own(play: Play, context: Context) -> None:
    async def scenario() -> None:
        async with goalwire.Node('guest', context=context) as node:
            assert node.context is context
            assert CONTEXTS.open == 0
        assert context.ok()

    play(scenario)


def test_a_node_that_cannot_be_made_leaves_nothing(play: Play) -> None:
    async def scenario() -> None:
        with pytest.raises(InvalidNodeNameException):
            await goalwire.Node('no name').__aenter__()
        with pytest.raises(Exception, match='use_sim_time'):
            await goalwire.Node('node', parameters={'use_sim_time': 'maybe'}).__aenter__()

    play(scenario)


def test_cancelling_the_entry_leaves_nothing(play: Play) -> None:
    async def scenario() -> None:
        entering = asyncio.create_task(goalwire.Node('node').__aenter__())
        await asyncio.sleep(0)
        entering.cancel()
        with pytest.raises(asyncio.CancelledError):
            await entering

    play(scenario)


@pytest.mark.parametrize('loop', LOOPS)
def test_an_error_of_the_block_leaves_it_as_it_is(isolated: dict[str, str], loop: str) -> None:
    async def scenario() -> None:
        async with goalwire.Node('node') as node:
            node.service(Trigger, 'trigger', lambda _: Trigger.Response())
            raise KeyError('mine')

    with pytest.raises(KeyError, match='mine'):
        run(scenario(), loop)
    assert CONTEXTS.open == 0


@pytest.mark.parametrize('loop', LOOPS)
def test_leaving_the_block_cancels_handlers_and_waits_for_their_cleaning_up(
    isolated: dict[str, str], loop: str
) -> None:
    ended: list[str] = []

    async def scenario() -> None:
        async def hang(_: Trigger.Request) -> Trigger.Response:
            began.set()
            try:
                await asyncio.Event().wait()
            finally:
                await turns()
                ended.append('handler')
            return Trigger.Response()

        began = asyncio.Event()
        async with goalwire.Node('hand') as hand:
            async with goalwire.Node('lamp') as lamp:
                lamp.service(Trigger, 'hang', hang)
                calling = asyncio.create_task(hand.client(Trigger, 'hang').call(timeout=PATIENCE))
                await began.wait()
            assert ended == ['handler']
            with pytest.raises((goalwire.ServerFailedError, goalwire.ServerLostError)):
                await calling
        assert len(asyncio.all_tasks()) == 1

    run(scenario(), loop)


def test_cancelling_the_task_of_a_node_ends_it_in_a_task_group(play: Play) -> None:
    async def scenario() -> None:
        async def live(name: str) -> None:
            async with goalwire.Node(name) as node:
                nodes.append(node)
                if len(nodes) == 2:
                    both.set()
                await asyncio.Event().wait()

        nodes: list[goalwire.Node] = []
        both = asyncio.Event()

        async def live_until_one_fails() -> None:
            async with asyncio.TaskGroup() as group:
                group.create_task(live('one'))
                group.create_task(live('two'))
                await both.wait()
                raise ValueError('enough')

        with pytest.raises(ExceptionGroup) as raised:
            await live_until_one_fails()
        assert [str(error) for error in raised.value.exceptions] == ['enough']
        assert all('closed' in repr(node) for node in nodes)

    play(scenario)


def test_shutdown_of_the_context_ends_what_waits(play: Play, context: Context) -> None:
    async def scenario() -> None:
        async with goalwire.Node('node', context=context) as node:
            client = node.client(SetBool, 'nobody')
            waits = [asyncio.create_task(client.call()), asyncio.create_task(client.wait_for_server())]
            await turns()  # both wait
            await asyncio.to_thread(context.shutdown)
            for wait in waits:
                with pytest.raises(ShutDownError, match='nobody'):
                    await wait

    play(scenario)


def test_a_web_server_in_the_same_loop_calls_a_service_for_each_request(play: Play) -> None:
    async def scenario() -> None:
        async def serve(reader: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
            wanted = (await reader.readline()).startswith(b'GET /on ')
            response = await client.call(data=wanted, timeout=PATIENCE)
            writer.write(f'HTTP/1.0 200 OK\r\n\r\n{response.success}'.encode())
            writer.close()
            await writer.wait_closed()

        async def get(path: str) -> bytes:
            reader, writer = await asyncio.open_connection(*server.sockets[0].getsockname())
            writer.write(f'GET {path} HTTP/1.0\r\n\r\n'.encode())
            answer = await reader.read()
            writer.close()
            await writer.wait_closed()
            return answer.splitlines()[-1]

        async with goalwire.Node('node') as node:
            node.service(SetBool, 'switch', lambda request: SetBool.Response(success=request.data))
            client = node.client(SetBool, 'switch')
            async with await asyncio.start_server(serve, '127.0.0.1', 0) as server:
                assert [await get('/on'), await get('/off')] == [b'True', b'False']

    play(scenario)


def test_both_fronts_talk_in_one_process(play: Play, context: Context) -> None:
    async def scenario() -> None:
        async with goalwire.Node('async') as node:
            response = await node.client(SetBool, 'switch').call(data=True, timeout=PATIENCE)
            assert response.message == 'from a thread'

    def switch(_: SetBool.Request, response: SetBool.Response) -> SetBool.Response:
        response.message = 'from a thread'
        return response

    spinning = Node('spinning', context=context)
    spinning.create_service(SetBool, 'switch', switch)
    executor = SingleThreadedExecutor(context=context)
    executor.add_node(spinning)
    with Spinner(executor):
        play(scenario)
    executor.shutdown()
    spinning.destroy_node()


def test_its_standing_services_answer(play: Play) -> None:
    async def scenario() -> None:
        async with goalwire.Node('asked') as asked, goalwire.Node('asking') as asking:
            asked.parameters.declare('speed', 3)
            asked.publisher(String, 'chat')
            get = asking.client(GetParameters, '/asked/get_parameters')
            (value,) = (await get.call(names=['speed'], timeout=PATIENCE)).values
            assert value.integer_value == 3
            describe = asking.client(GetTypeDescription, '/asked/get_type_description')
            answer = await describe.call(type_name='x', type_hash=type_hash(String), timeout=PATIENCE)
            assert answer.successful

    play(scenario)
