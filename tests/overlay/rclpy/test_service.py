"""Service servers: what a callback may return, raise and wait for, and what its client sees."""

from __future__ import annotations

import asyncio
import threading
from collections.abc import Callable, Iterator
from typing import Any

import pytest
from example_interfaces.srv import AddTwoInts
from helpers.collector import Collector
from helpers.patience import PATIENCE
from helpers.spinning import MakeNode, Spin, result_of, wait_until
from rclpy.callback_groups import ReentrantCallbackGroup
from rclpy.client import Client
from rclpy.context import Context
from rclpy.exceptions import InvalidHandle
from rclpy.executors import Executor
from rclpy.task import Future
from std_srvs.srv import Trigger

from goalwire.errors import EncodeError

pytestmark = pytest.mark.also_on_dds

Request, Response = AddTwoInts.Request, AddTwoInts.Response


def add(request: Any, response: Any) -> Any:
    response.sum = request.a + request.b
    return response


def fresh(request: Any, response: Any) -> Any:
    return Response(sum=9)


async def add_later(request: Any, response: Any) -> Any:
    await asyncio.sleep(0.01)
    return add(request, response)


@pytest.mark.parametrize(
    ('callback', 'answer'), [(add, 5), (fresh, 9), (add_later, 5)], ids=['plain', 'fresh', 'coroutine']
)
def test_a_callback_answers(
    make_node: MakeNode, executor: Executor, callback: Callable[..., Any], answer: int
) -> None:
    node = make_node()
    node.create_service(AddTwoInts, 'add', callback)
    client = node.create_client(AddTwoInts, 'add')
    assert client.wait_for_service(10)
    executor.add_node(node)
    future = client.call_async(Request(a=2, b=3))
    executor.spin_until_future_complete(future, 10)
    assert future.result() == Response(sum=answer)


def generator(request: Any, response: Any) -> Iterator[Any]:
    yield response


async def coroutine_of_none(request: Any, response: Any) -> None:
    return None


@pytest.mark.parametrize(
    'callback',
    [
        lambda request, response: None,
        lambda request, response: Trigger.Response(),
        lambda request, response: request,
        lambda request, response: True,
        lambda request, response: Response,
        coroutine_of_none,
        generator,
    ],
    ids=[
        'None', 'another type', 'the request', 'True', 'the class', 'coroutine of None', 'generator',
    ],
)  # fmt: skip
def test_what_is_no_response_raises_type_error_out_of_spin_and_gives_the_request_up(
    make_node: MakeNode, executor: Executor, callback: Callable[..., Any]
) -> None:
    node = make_node()
    node.create_service(AddTwoInts, 'add', callback)
    client = node.create_client(AddTwoInts, 'add')
    assert client.wait_for_service(10)
    executor.add_node(node)
    future = client.call_async(Request())
    with pytest.raises(TypeError):
        executor.spin_until_future_complete(future, 10)
    assert not future.done()


def test_the_type_error_says_what_to_return(make_node: MakeNode, spin: Spin) -> None:
    node = make_node()
    node.create_service(AddTwoInts, 'add', lambda request, response: None)  # type: ignore[arg-type, return-value]
    client = node.create_client(AddTwoInts, 'add')
    assert client.wait_for_service(10)
    spinner = spin(node)
    _ = client.call_async(Request())
    error = spinner.expect_raised(TypeError)
    assert "Service '/add'" in str(error)
    assert 'NoneType' in str(error)
    assert 'AddTwoInts_Response' in str(error)


@pytest.mark.parametrize('coroutine', [False, True], ids=['plain', 'coroutine'])
def test_a_callback_that_raises_gives_the_request_up_and_the_next_one_is_answered(
    make_node: MakeNode, executor: Executor, coroutine: bool
) -> None:
    node = make_node()

    def callback(request: Any, response: Any) -> Any:
        if request.a < 0:
            raise ValueError('boom')
        return add(request, response)

    async def callback_later(request: Any, response: Any) -> Any:
        await asyncio.sleep(0)
        return callback(request, response)

    node.create_service(AddTwoInts, 'add', callback_later if coroutine else callback)
    client = node.create_client(AddTwoInts, 'add')
    assert client.wait_for_service(10)
    executor.add_node(node)
    lost = client.call_async(Request(a=-1))
    with pytest.raises(ValueError, match='boom'):
        executor.spin_until_future_complete(lost, 10)
    future = client.call_async(Request(a=1))
    executor.spin_until_future_complete(future, 10)
    assert future.result() == Response(sum=1)
    assert not lost.done()


def test_a_response_that_cannot_go_on_the_wire_is_named(make_node: MakeNode, spin: Spin) -> None:
    node = make_node()

    def callback(request: Any, response: Any) -> Any:
        response.sum = 'x'
        return response

    node.create_service(AddTwoInts, 'add', callback)
    client = node.create_client(AddTwoInts, 'add')
    assert client.wait_for_service(10)
    spinner = spin(node)
    future = client.call_async(Request())
    error = spinner.expect_raised(EncodeError)
    assert 'sum' in str(error)
    assert "'x'" in str(error)
    assert not future.done()


def test_every_server_of_a_name_is_asked_and_one_answer_counts(
    context: Context, make_node: MakeNode, spin: Spin
) -> None:
    asked = Collector[str]()
    servers = make_node('servers')

    def named(name: str) -> Callable[[Any, Any], Any]:
        def callback(request: Any, response: Any) -> Any:
            asked(name)
            return add(request, response)

        return callback

    servers.create_service(AddTwoInts, 'add', named('A'))
    servers.create_service(AddTwoInts, 'add', named('B'))
    node = make_node()
    client = node.create_client(AddTwoInts, 'add')
    wait_until(context, lambda: node.count_services('add') == 2)
    spin(servers)
    answers = [result_of(client.call_async(Request(a=number))).sum for number in range(3)]
    assert answers == [0, 1, 2]
    assert sorted(asked.expect(6)) == ['A'] * 3 + ['B'] * 3


def test_a_request_that_is_no_message_never_reaches_the_callback(make_node: MakeNode, spin: Spin) -> None:
    from goalwire.entities.type_support import service_support
    from goalwire.transport.contract import Endpoint, EndpointKind

    node, asked, ended = make_node(), Collector[Any](), threading.Event()

    def callback(request: Any, response: Any) -> Any:
        asked(request)
        return response

    server = node.create_service(AddTwoInts, 'add', callback)
    client = node.create_client(AddTwoInts, 'add')
    assert client.wait_for_service(10)
    support = service_support(AddTwoInts)
    port = node.handle.port.client(
        Endpoint(EndpointKind.CLIENT, '/add', support.type_name, support.type_hash, client.qos)
    )
    spin(node)
    port.request(b'\x00\x01\x00\x00rubbish', lambda _: pytest.fail('answered'), lambda _: ended.set())
    assert ended.wait(PATIENCE)
    assert result_of(client.call_async(Request(a=1))) == Response()
    assert asked.items == [Request(a=1)]
    assert server._server.rejected == 1
    port.close()


def test_a_destroyed_service_gives_up_the_requests_that_wait(context: Context, make_node: MakeNode) -> None:
    servers, node = make_node('servers'), make_node()
    service = servers.create_service(AddTwoInts, 'add', add)
    client = node.create_client(AddTwoInts, 'add')
    assert client.wait_for_service(10)
    future = client.call_async(Request())
    assert servers.destroy_service(service) is True
    assert servers.destroy_service(service) is False
    wait_until(context, lambda: not client.service_is_ready())
    assert not future.done()
    with pytest.raises(InvalidHandle):
        _ = service.service_name
    with pytest.raises(InvalidHandle):
        service.send_response(Response(), None)  # type: ignore[arg-type]


def test_a_program_may_take_over_how_responses_are_sent_and_answer_later(
    make_node: MakeNode, spin: Spin
) -> None:
    held: Collector[tuple[Any, Any]] = Collector()
    servers, node = make_node('servers'), make_node()
    callback: Callable[[Any, Any], Any] = lambda request, _response: request  # noqa: E731 - no response
    service = servers.create_service(AddTwoInts, 'add', callback)
    send = service.send_response
    service.send_response = lambda response, header: held((response, header))  # type: ignore[method-assign]
    client = node.create_client(AddTwoInts, 'add')
    spin(servers)
    assert client.wait_for_service(10)
    future = client.call_async(Request(a=2, b=3))
    request, header = held.expect()[0]
    assert not future.done()
    send(Response(sum=request.a + request.b), header)
    assert result_of(future) == Response(sum=5)


def test_a_service_ends_with_its_block(make_node: MakeNode) -> None:
    with make_node().create_service(AddTwoInts, 'add', add) as service:
        assert service.service_name == '/add'
        assert service.srv_name == 'add'
    assert service.destroyed


def _call(client: Client[Any, Any], answers: Collector[Any]) -> None:
    answers(client.call(Request(a=2, b=3), 10))


def test_a_callback_may_call_another_service_and_wait(make_node: MakeNode, spin: Spin) -> None:
    servers, node, group = make_node('servers'), make_node(), ReentrantCallbackGroup()
    servers.create_service(AddTwoInts, 'add', add)
    client = node.create_client(AddTwoInts, 'add')

    def callback(request: Any, response: Any) -> Any:
        answer = client.call(request, 10)
        assert answer is not None
        response.sum = answer.sum * 10
        return response

    node.create_service(AddTwoInts, 'ten_times', callback, callback_group=group)
    outer = make_node('outer').create_client(AddTwoInts, 'ten_times')
    assert client.wait_for_service(10)
    assert outer.wait_for_service(10)
    spin(servers)
    spin(node)
    assert outer.call(Request(a=2, b=3), 10) == Response(sum=50)


def test_ten_callbacks_wait_for_services_beside_each_other(make_node: MakeNode, spin: Spin) -> None:
    node, group, others = make_node(), ReentrantCallbackGroup(), ReentrantCallbackGroup()
    together = threading.Barrier(10, timeout=PATIENCE)
    node.create_service(AddTwoInts, 'add', add, callback_group=others)
    inner = node.create_client(AddTwoInts, 'add')

    def callback(request: Any, response: Any) -> Any:
        together.wait(PATIENCE)
        return inner.call(request, 10)

    node.create_service(AddTwoInts, 'slow', callback, callback_group=group)
    client = node.create_client(AddTwoInts, 'slow')
    assert client.wait_for_service(10)
    assert inner.wait_for_service(10)
    spin(node, threads=12)
    futures = [client.call_async(Request(a=number)) for number in range(10)]
    assert [result_of(future).sum for future in futures] == list(range(10))


def test_an_await_in_the_default_group_completes(make_node: MakeNode, executor: Executor) -> None:
    """rclpy never completes this one: client and timer share the node's exclusive group."""
    node, done = make_node(), Future[Any]()
    servers = make_node('servers')
    servers.create_service(AddTwoInts, 'add', add)
    client = node.create_client(AddTwoInts, 'add')
    assert client.wait_for_service(10)

    async def callback() -> None:
        timer.cancel()
        done.set_result(await client.call_async(Request(a=1, b=1)))

    timer = node.create_timer(0.001, callback)
    executor.add_node(node)
    executor.add_node(servers)
    executor.spin_until_future_complete(done, 10)
    assert done.result() == Response(sum=2)
