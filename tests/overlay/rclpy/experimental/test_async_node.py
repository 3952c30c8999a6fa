"""AsyncNode: its life, what it shares with Node, and who it lives beside."""

from __future__ import annotations

import asyncio
import threading
from collections.abc import Callable
from pathlib import Path
from types import ModuleType

import pytest
from helpers.collector import Collector
from helpers.fresh import output_of
from helpers.loops import LOOPS, run, turns
from helpers.spinning import MakeNode, Spin, result_of
from rcl_interfaces.srv import GetLoggerLevels, GetParameters
from rclpy import experimental
from rclpy.context import Context
from rclpy.exceptions import InvalidHandle, NotInitializedException
from rclpy.experimental import AsyncNode
from rclpy.node import Node
from rclpy.parameter import Parameter
from rclpy.qos import QoSProfile, ReliabilityPolicy
from std_msgs.msg import Int64, String
from std_srvs.srv import SetBool
from type_description_interfaces.srv import GetTypeDescription

from goalwire.errors import ShutDownError
from goalwire.idl import type_hash
from goalwire.logging import add_sink

MakeAsyncNode = Callable[..., AsyncNode]


def test_nothing_of_it_is_imported_before_it_is_asked_for(tmp_path: Path) -> None:
    program = """
        import sys, rclpy, rclpy.node, rclpy.experimental
        heavy = {'asyncio', 'goalwire.execution.asyncio.executor'}
        print(heavy & set(sys.modules))
        from rclpy.experimental import AsyncNode
        print(heavy <= set(sys.modules))
    """
    assert output_of(program, cwd=tmp_path).split('\n') == ['set()', 'True']


@pytest.mark.parametrize('name', [name for name in experimental.__all__ if name.startswith('Async')])
def test_each_class_is_found_in_the_package_and_in_its_module(name: str) -> None:
    from importlib import import_module

    module: ModuleType = import_module(f'rclpy.experimental.async_{name.removeprefix("Async").lower()}')
    assert getattr(module, name) is getattr(experimental, name)
    with pytest.raises(AttributeError, match='Nothing'):
        experimental.Nothing  # noqa: B018


@pytest.mark.parametrize('loop', LOOPS)
def test_a_node_lives_as_long_as_its_block(make_async: MakeAsyncNode, loop: str) -> None:
    async def scenario() -> None:
        async with make_async('short', namespace='/ns') as node:
            assert node.get_fully_qualified_name() == '/ns/short'
            assert '/ns/short' in node.get_fully_qualified_node_names()
            assert repr(node).endswith(': /ns/short>')
        with pytest.raises(InvalidHandle):
            node.get_name()
        assert not node.handle.context.graph.node_exists('short', '/ns')

    run(scenario(), loop)


def test_a_node_is_entered_once(make_async: MakeAsyncNode) -> None:
    async def scenario() -> None:
        async with make_async() as node:
            with pytest.raises(RuntimeError, match="the node '/node': it is running already"):
                await node.__aenter__()
        with pytest.raises(RuntimeError, match="cannot use the node '/node': it was destroyed"):
            await node.run()

    run(scenario())


def test_what_a_destroyed_node_is_asked_for_is_refused_with_a_runtime_error(
    make_async: MakeAsyncNode,
) -> None:
    node = make_async()
    node.destroy_node()
    node.destroy_node()
    for make in (
        lambda: node.create_publisher(String, 'topic', 1),
        lambda: node.create_subscription(String, 'topic', print, 1),
        lambda: node.create_client(SetBool, 'service'),
        lambda: node.create_service(SetBool, 'service', lambda _, response: response),
        lambda: node.create_timer(1.0, print),
    ):
        with pytest.raises(RuntimeError, match='destroyed'):
            make()


def test_a_node_needs_a_context_that_is_up() -> None:
    with pytest.raises(NotInitializedException):
        AsyncNode('node', context=Context())


def test_run_enters_the_node_and_returns_when_it_is_destroyed(make_async: MakeAsyncNode) -> None:
    async def scenario() -> None:
        node = make_async()

        async def stop(message: String) -> None:
            received.append(message.data)
            node.destroy_node()

        received: list[str] = []
        publisher = node.create_publisher(String, 'stop', 1)
        node.create_subscription(String, 'stop', stop, 1)
        asyncio.get_running_loop().call_soon(publisher.publish, String(data='now'))
        await node.run()
        assert received == ['now']
        assert node.handle.destroyed

    run(scenario())


def test_run_within_the_block_waits_there(make_async: MakeAsyncNode) -> None:
    async def scenario() -> None:
        async with make_async() as node:
            node.create_timer(0.001, node.destroy_node)
            await node.run()

    run(scenario())


@pytest.mark.parametrize('loop', LOOPS)
def test_run_returns_when_the_context_is_shut_down(
    make_async: MakeAsyncNode, context: Context, loop: str
) -> None:
    async def scenario() -> None:
        node = make_async()
        thread = threading.Timer(0.01, context.shutdown)
        thread.start()
        await node.run()
        thread.join()
        assert node.handle.destroyed

    run(scenario(), loop)


def test_shutdown_ends_whatever_the_body_waits_for(make_async: MakeAsyncNode, context: Context) -> None:
    async def scenario() -> None:
        async with make_async() as node:
            client = node.create_client(SetBool, 'nobody')
            waits = [
                asyncio.create_task(client.call(SetBool.Request())),
                asyncio.create_task(client.wait_for_service()),
                asyncio.create_task(node.wait_for_node('/nobody')),
            ]
            await turns()  # all wait
            await asyncio.to_thread(context.shutdown)
            for wait in waits:
                with pytest.raises(ShutDownError, match='nobody'):
                    await wait

    run(scenario())


def test_cancelling_run_cancels_callbacks_and_destroys_the_node(make_async: MakeAsyncNode) -> None:
    ended: list[str] = []

    async def scenario() -> None:
        node = make_async()
        begun = asyncio.Event()

        async def forever() -> None:
            begun.set()
            try:
                await asyncio.Event().wait()
            finally:
                ended.append('callback')
                publisher.publish(String(data='bye'))  # the node is there until its callbacks have cleaned up

        publisher = node.create_publisher(String, 'topic', 1)
        node.create_timer(0.001, forever)
        running = asyncio.create_task(node.run())
        await begun.wait()
        running.cancel()
        with pytest.raises(asyncio.CancelledError):
            await running
        assert node.handle.destroyed
        assert len(asyncio.all_tasks()) == 1

    run(scenario())
    assert ended == ['callback']


def test_an_error_of_the_body_leaves_in_a_group_as_from_a_task_group(make_async: MakeAsyncNode) -> None:
    async def scenario() -> None:
        async with make_async():
            raise KeyError('body')

    with pytest.raises(ExceptionGroup) as raised:
        run(scenario())
    assert [type(error) for error in raised.value.exceptions] == [KeyError]


def test_an_error_of_a_callback_comes_out_of_run(make_async: MakeAsyncNode) -> None:
    async def scenario() -> None:
        node = make_async()

        async def fail() -> None:
            raise ValueError('timer')

        node.create_timer(0.001, fail)
        await node.run()

    with pytest.raises(ExceptionGroup) as raised:
        run(scenario())
    assert [str(error) for error in raised.value.exceptions] == ['timer']


def test_nodes_run_in_a_task_group_of_the_program(make_async: MakeAsyncNode) -> None:
    async def scenario() -> list[int]:
        talker, listener = make_async('talker'), make_async('listener')
        heard: list[int] = []

        def hear(message: Int64) -> None:
            heard.append(message.data)
            if len(heard) == 3:
                talker.destroy_node()
                listener.destroy_node()

        listener.create_subscription(Int64, 'count', hear, 10)
        publisher = talker.create_publisher(Int64, 'count', 10)
        numbers = iter(range(10))
        talker.create_timer(0.002, lambda: publisher.publish(Int64(data=next(numbers))))
        async with asyncio.TaskGroup() as group:
            group.create_task(talker.run())
            group.create_task(listener.run())
        return heard

    assert run(scenario()) == [0, 1, 2]


def test_it_lives_beside_a_node_that_spins_in_a_thread(
    make_async: MakeAsyncNode, make_node: MakeNode, spin: Spin
) -> None:
    threads: list[int] = []

    def switch(request: SetBool.Request, response: SetBool.Response) -> SetBool.Response:
        threads.append(threading.get_ident())
        response.success = request.data
        return response

    spinning: Node = make_node('spinning')
    spinning.create_service(SetBool, 'threaded', switch)
    back = spinning.create_client(SetBool, 'in_loop')
    spin(spinning)

    async def scenario() -> None:
        async with make_async() as node:
            node.create_service(SetBool, 'in_loop', switch)
            client = node.create_client(SetBool, 'threaded')
            await client.wait_for_service()
            assert (await client.call(SetBool.Request(data=True))).success
            response = await asyncio.to_thread(lambda: back.call(SetBool.Request(data=True), 10.0))
            assert response is not None
            assert response.success

    run(scenario())
    assert threads[0] != threads[1] == threading.get_ident()
    assert result_of(spinning.executor.create_task(int)) == 0  # type: ignore[union-attr]


def test_wait_for_node_is_woken_by_its_coming(make_async: MakeAsyncNode) -> None:
    async def scenario() -> None:
        async with make_async('watcher') as node:
            waiting = asyncio.create_task(node.wait_for_node('late/comer', check_interval=60.0))
            async with make_async('stranger'):
                await node.wait_for_node('/stranger')
            assert not waiting.done()
            async with make_async('comer', namespace='/late'):
                await waiting
            with pytest.raises(TimeoutError):
                async with asyncio.timeout(0.01):
                    await node.wait_for_node('/late/other')

    run(scenario())


def test_its_parameters_are_those_of_node(make_async: MakeAsyncNode) -> None:
    node = make_async(parameter_overrides=[Parameter('speed', value=3)])
    assert node.declare_parameter('speed', 1).value == 3
    assert node.set_parameters([Parameter('speed', value=4)])[0].successful
    assert node.get_parameter('speed').value == 4


def test_qos_that_does_not_fit_is_warned_of_on_both_sides(make_async: MakeAsyncNode) -> None:
    warnings: Collector[str] = Collector()

    async def scenario() -> None:
        async with make_async() as node:
            node.create_publisher(
                String, 'chat', QoSProfile(depth=1, reliability=ReliabilityPolicy.BEST_EFFORT)
            )
            node.create_subscription(String, 'chat', print, 1)
            await asyncio.to_thread(warnings.expect, 2)

    with add_sink(lambda record: warnings(record.message)):
        run(scenario())
    assert [text.split(' incompatible QoS')[0] for text in sorted(warnings.items)] == [
        "New publisher discovered on topic 'chat', offering",
        "New subscription discovered on topic 'chat', requesting",
    ]


def test_what_it_logs_goes_out_on_rosout_with_the_qos_that_was_asked_for(make_async: MakeAsyncNode) -> None:
    node = make_async(rosout_qos_profile=7)
    (info,) = node.get_publishers_info_by_topic('/rosout')
    assert info.qos_profile.depth == 7
    silent = make_async('silent', enable_rosout=False)
    assert silent.count_publishers('/rosout') == 1


def test_its_standing_services_answer_in_the_loop(make_async: MakeAsyncNode) -> None:
    async def scenario() -> None:
        async with make_async('asked', enable_logger_service=True) as asked, make_async('asking') as asking:
            asked.declare_parameter('speed', 3)
            asked.create_publisher(String, 'topic', 1)
            get = asking.create_client(GetParameters, '/asked/get_parameters')
            levels = asking.create_client(GetLoggerLevels, '/asked/get_logger_levels')
            describe = asking.create_client(GetTypeDescription, '/asked/get_type_description')
            for client in (get, levels, describe):
                await client.wait_for_service()
            (value,) = (await get.call(GetParameters.Request(names=['speed']))).values
            assert value.integer_value == 3
            (level,) = (await levels.call(GetLoggerLevels.Request(names=['asked']))).levels
            assert level.name == 'asked'
            described = await describe.call(GetTypeDescription.Request(type_hash=type_hash(String)))
            assert described.failure_reason == ''
            assert described.type_description.type_description.type_name == 'std_msgs/msg/String'

    run(scenario())


def test_without_start_parameter_services_none_are_offered(make_async: MakeAsyncNode) -> None:
    node = make_async(start_parameter_services=False)
    services = dict(node.get_service_names_and_types_by_node('node', '/'))
    assert '/node/get_parameters' not in services


def test_a_blocking_call_of_a_node_of_the_same_loop_is_refused(
    make_async: MakeAsyncNode, make_node: MakeNode
) -> None:
    from goalwire.errors import WouldDeadlockError

    async def scenario() -> None:
        async with make_async() as node:
            node.create_service(SetBool, 'here', lambda _, response: response)
            client = make_node('other').create_client(SetBool, 'here')
            with pytest.raises(WouldDeadlockError, match="'/here' can never be answered"):
                client.call(SetBool.Request())

    run(scenario())
