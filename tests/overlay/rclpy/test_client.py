"""Service clients: futures, pending requests, blocking calls, servers that come and go."""

from __future__ import annotations

import threading
import time
from collections.abc import Callable
from typing import Any, TypeAlias, assert_type

import pytest
from example_interfaces.srv import AddTwoInts
from helpers.collector import Collector
from helpers.patience import PATIENCE
from helpers.spinning import MakeNode, Spin, result_of
from rclpy.callback_groups import MutuallyExclusiveCallbackGroup, ReentrantCallbackGroup
from rclpy.client import Client
from rclpy.context import Context
from rclpy.exceptions import InvalidHandle
from rclpy.executors import Executor
from rclpy.task import Future
from std_msgs.msg import String
from std_srvs.srv import Trigger

from goalwire.errors import (
    DeadlineError,
    EncodeError,
    NoServerError,
    RCLError,
    ShutDownError,
    WouldDeadlockError,
)

Request, Response = AddTwoInts.Request, AddTwoInts.Response
AddClient: TypeAlias = Client[AddTwoInts.Request, AddTwoInts.Response]


def add(request: Any, response: Any) -> Any:
    response.sum = request.a + request.b
    return response


def unanswered_of(client: Client[Any, Any], monkeypatch: pytest.MonkeyPatch) -> Collector[None]:
    """Let a collector hear of each request that nobody answers."""
    heard: Collector[None] = Collector()
    report = client.report_unanswered

    def told(reason: str) -> None:
        report(reason)
        heard(None)

    monkeypatch.setattr(client, 'report_unanswered', told)
    return heard


@pytest.fixture
def pair(make_node: MakeNode, spin: Spin) -> AddClient:
    """A client of a server that another node spins."""
    server, node = make_node('server'), make_node()
    server.create_service(AddTwoInts, 'add', add)
    client = node.create_client(AddTwoInts, 'add')
    assert client.wait_for_service(PATIENCE)
    spin(server)
    return client


@pytest.mark.parametrize(
    'wrong', [1, None, 'x', AddTwoInts, Response(), Trigger.Request()], ids=lambda value: repr(value)[-30:]
)
def test_only_requests_of_the_service_are_sent(pair: AddClient, wrong: Any) -> None:
    with pytest.raises(TypeError, match=r'^expected .*AddTwoInts\.Request, got '):
        _ = pair.call_async(wrong)
    with pytest.raises(TypeError, match=r'^expected .*AddTwoInts\.Request, got '):
        pair.call(wrong)
    assert pair.pending == {}


@pytest.mark.parametrize('timeout', [None, PATIENCE])
def test_programs_keep_what_they_like_on_a_future(pair: AddClient, timeout: float | None) -> None:
    pair.call_timeout = timeout
    request = Request(a=1, b=2)
    future: Any = pair.call_async(request)
    for name in ('request', 'client', 'sequence', 'sent_at', 'sequence_number', 'reason', 'terms', 'payload'):
        setattr(future, name, name)
    assert result_of(future).sum == 3
    assert future.request == 'request'


def test_a_request_that_cannot_go_on_the_wire_is_named(
    pair: AddClient,
) -> None:
    with pytest.raises(EncodeError, match=r'AddTwoInts_Request: a: .*9223372036854775808'):
        _ = pair.call_async(Request(a=2**63))
    assert pair.pending == {}


def test_a_future_is_pending_then_done(make_node: MakeNode, executor: Executor) -> None:
    node = make_node()
    node.create_service(AddTwoInts, 'add', add)
    client = node.create_client(AddTwoInts, 'add')
    assert client.wait_for_service(PATIENCE)
    executor.add_node(node)
    future = client.call_async(Request(a=1, b=2))
    assert (future.done(), future.cancelled(), future.result()) == (False, False, None)
    assert client.get_pending_request(1) is future
    with pytest.raises(KeyError, match='77'):
        _ = client.get_pending_request(77)
    executor.spin_until_future_complete(future, PATIENCE)
    assert (future.done(), future.cancelled()) == (True, False)
    assert future.result() == Response(sum=3)
    assert future.exception() is None
    with pytest.raises(KeyError):
        _ = client.get_pending_request(1)


def test_spin_once_returns_for_a_response_that_only_a_loop_looks_at(
    make_node: MakeNode, spin: Spin, executor: Executor
) -> None:
    """The loop of many tutorials: spin once, look at the future, spin once more. No spin may time out."""
    server, node = make_node('server'), make_node()
    server.create_service(AddTwoInts, 'add', add)
    client = node.create_client(AddTwoInts, 'add')
    assert client.wait_for_service(PATIENCE)
    spin(server)
    executor.add_node(node)
    begun = time.monotonic()
    for number in range(5):
        future = client.call_async(Request(a=number))
        while not future.done():
            executor.spin_once(timeout_sec=PATIENCE)
        assert future.result() == Response(sum=number)
    first = client.call_async(Request())
    result_of(client.call_async(Request()))  # when it is here, so is the first, which nobody waited for
    executor.spin_once(timeout_sec=PATIENCE)
    assert first.done()
    assert time.monotonic() - begun < PATIENCE


def test_done_callbacks_run_in_the_executor_in_order(make_node: MakeNode, executor: Executor) -> None:
    node, over = make_node(), Future[bool]()
    node.create_service(AddTwoInts, 'add', add)
    client = node.create_client(AddTwoInts, 'add')
    assert client.wait_for_service(PATIENCE)
    executor.add_node(node)
    called: list[str] = []
    future = client.call_async(Request())
    future.add_done_callback(lambda _: called.append('first'))
    future.add_done_callback(lambda _: over.set_result(True))
    executor.spin_until_future_complete(over, PATIENCE)
    assert called == ['first']


def test_a_forgotten_request_stays_pending_for_ever(pair: AddClient, make_node: MakeNode) -> None:
    slow = make_node('slow')  # nobody spins this one
    slow.create_service(AddTwoInts, 'slow', add)
    client = make_node().create_client(AddTwoInts, 'slow')
    assert client.wait_for_service(PATIENCE)
    future = client.call_async(Request())
    client.remove_pending_request(future)
    client.remove_pending_request(future)
    assert client.pending == {}
    assert (future.done(), future.cancelled()) == (False, False)


def test_the_end_of_ones_own_context_is_not_blamed_on_the_server(
    make_node: MakeNode, capfd: pytest.CaptureFixture[str]
) -> None:
    node = make_node()  # nobody spins it
    node.create_service(AddTwoInts, 'slow', add)
    client = node.create_client(AddTwoInts, 'slow')
    assert client.wait_for_service(PATIENCE)
    future = client.call_async(Request())
    node.context.shutdown()
    assert not future.done()
    assert 'no server answered' not in capfd.readouterr().err


def test_a_cancelled_request_is_forgotten(make_node: MakeNode, executor: Executor) -> None:
    node = make_node()
    node.create_service(AddTwoInts, 'add', add)
    client = node.create_client(AddTwoInts, 'add')
    assert client.wait_for_service(PATIENCE)
    future = client.call_async(Request())
    future.cancel()
    assert (future.done(), future.cancelled(), future.result()) == (False, True, None)
    with pytest.raises(KeyError):
        _ = client.get_pending_request(1)
    executor.add_node(node)
    other = client.call_async(Request(a=4))
    executor.spin_until_future_complete(other, PATIENCE)
    assert other.result() == Response(sum=4)
    assert (future.done(), future.cancelled(), future.result()) == (False, True, None)


def test_a_call_waits_on_its_own_thread(pair: AddClient) -> None:
    assert assert_type(pair.call(Request(a=1, b=74)), AddTwoInts.Response | Any) == Response(sum=75)
    assert pair.call(Request(a=1, b=74), timeout_sec=PATIENCE) == Response(sum=75)


def test_calls_of_many_threads_get_their_own_answers(
    pair: AddClient,
) -> None:
    answers: Collector[tuple[int, int]] = Collector()

    def call(number: int) -> None:
        for step in range(10):
            response = pair.call(Request(a=number, b=step), PATIENCE)
            assert response is not None
            answers((number + step, response.sum))

    threads = [threading.Thread(target=call, args=(1000 * number,)) for number in range(8)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert len(answers.items) == 80
    assert all(expected == got for expected, got in answers.items)
    assert pair.pending == {}


def test_a_call_that_nobody_answers_ends_with_an_error_and_leaves_nothing(
    make_node: MakeNode, monkeypatch: pytest.MonkeyPatch
) -> None:
    client = make_node().create_client(AddTwoInts, 'nosuch')
    heard = unanswered_of(client, monkeypatch)
    with pytest.raises(TimeoutError, match=r"service '/nosuch': no server came within 0\.05 s") as late:
        client.call(Request(), timeout_sec=0.05)
    assert isinstance(late.value, NoServerError)
    with pytest.raises(TimeoutError):
        client.call(Request(), 0)
    future = client.call_async(Request())
    heard.expect(1)
    assert not future.done()
    assert not future.cancelled()
    heard.wait_for(lambda _: client.pending == {})


def test_a_request_before_the_server_exists_is_lost(
    make_node: MakeNode, spin: Spin, monkeypatch: pytest.MonkeyPatch
) -> None:
    server, node = make_node('server'), make_node()
    client = node.create_client(AddTwoInts, 'add')
    heard = unanswered_of(client, monkeypatch)
    early = client.call_async(Request())
    heard.expect()
    server.create_service(AddTwoInts, 'add', add)
    assert client.wait_for_service(PATIENCE)
    spin(server)
    assert client.call(Request(a=1), PATIENCE) == Response(sum=1)
    assert not early.done()


def test_a_client_waits_for_a_server_that_starts_later(make_node: MakeNode) -> None:
    client, ready = make_node().create_client(AddTwoInts, 'add'), Collector[bool]()
    assert client.service_is_ready() is False
    assert client.wait_for_service(0) is False
    assert client.wait_for_service(timeout_sec=0.05) is False
    thread = threading.Thread(target=lambda: ready(client.wait_for_service(PATIENCE)))
    thread.start()
    make_node('server').create_service(AddTwoInts, 'add', add)
    assert ready.expect() == [True]
    thread.join()
    assert client.service_is_ready() is True


def test_a_server_of_another_type_does_not_count(make_node: MakeNode) -> None:
    node = make_node()
    node.create_service(Trigger, 'add', lambda request, response: response)
    client = make_node('other').create_client(AddTwoInts, 'add')
    assert client.wait_for_service(0.1) is False


def test_a_call_that_takes_too_long_ends_with_an_error(make_node: MakeNode, spin: Spin) -> None:
    node = make_node()
    hold = threading.Event()

    def answer(request: AddTwoInts.Request, response: AddTwoInts.Response) -> AddTwoInts.Response:
        hold.wait(PATIENCE)
        return response

    node.create_service(AddTwoInts, 'slow', answer)
    spin(node)
    client = make_node('other').create_client(AddTwoInts, 'slow')
    assert client.wait_for_service(PATIENCE)
    with pytest.raises(DeadlineError, match=r"service '/slow': no response came within 0\.05 s"):
        client.call(Request(), timeout_sec=0.05)
    hold.set()
    assert client.pending == {}
    assert client.call(Request(), timeout_sec=PATIENCE) == Response()


def test_a_destroyed_client_refuses_to_work(make_node: MakeNode) -> None:
    node = make_node()
    client = node.create_client(AddTwoInts, 'add')
    pending = client.call_async(Request())
    assert node.destroy_client(client) is True
    assert node.destroy_client(client) is False
    assert (pending.done(), pending.cancelled()) == (False, False)
    for use in (
        lambda: client.call_async(Request()),
        lambda: client.call(Request(), timeout_sec=0.1),
        client.service_is_ready,
        lambda: client.wait_for_service(0.1),
        lambda: client.service_name,
    ):
        with pytest.raises(InvalidHandle, match='destruction was requested'):
            use()


def test_calling_after_shutdown_says_so(context: Context, make_node: MakeNode) -> None:
    client = make_node().create_client(AddTwoInts, 'add')
    context.shutdown()
    with pytest.raises(RCLError, match="cannot call '/add': the context was shut down"):
        client.call(Request())


def test_shutdown_wakes_who_waits(context: Context, make_node: MakeNode) -> None:
    server, node = make_node('server'), make_node()  # nobody spins the server
    server.create_service(AddTwoInts, 'add', add)
    client, missing = node.create_client(AddTwoInts, 'add'), node.create_client(AddTwoInts, 'nosuch')
    assert client.wait_for_service(PATIENCE)
    begun, came = Collector[None](), Collector[str]()

    def wait_for(what: Callable[[], object]) -> None:
        begun(None)
        with pytest.raises(ShutDownError) as raised:
            what()
        came(str(raised.value).split(';')[0])

    waits: list[Callable[[], object]] = [
        lambda: client.call(Request()),
        lambda: client.call(Request(), timeout_sec=PATIENCE),
        missing.wait_for_service,
    ]
    threads = [threading.Thread(target=wait_for, args=(wait,)) for wait in waits]
    for thread in threads:
        thread.start()
    begun.expect(len(threads), PATIENCE)
    context.shutdown()
    for thread in threads:
        thread.join(PATIENCE)
        assert not thread.is_alive()
    assert sorted(came.items) == [
        *2 * ["cannot call '/add': the context was shut down"],
        "node '/node': the context was shut down",
    ]
    with pytest.raises(RCLError):
        client.service_is_ready()


def test_a_client_ends_with_its_block(make_node: MakeNode) -> None:
    with make_node().create_client(AddTwoInts, '~/add') as client:
        assert client.service_name == '/node/add'
        assert client.srv_name == '~/add'
    assert client.destroyed


# -- calls inside callbacks ------------------------------------------------------------------------------


@pytest.mark.parametrize('threads', [1, 4], ids=['single', 'multi'])
def test_a_call_that_would_wait_for_itself_raises_at_once(
    make_node: MakeNode, spin: Spin, threads: int
) -> None:
    """rclpy waits for ever; both are in the node's exclusive group."""
    node, raised = make_node(), Collector[BaseException]()
    node.create_service(AddTwoInts, 'add', add)
    client = node.create_client(AddTwoInts, 'add')
    assert client.wait_for_service(PATIENCE)

    def callback() -> None:
        timer.cancel()
        try:
            client.call(Request())
        except WouldDeadlockError as error:
            raised(error)

    timer = node.create_timer(0.001, callback)
    spin(node, threads=threads)
    text = str(raised.expect()[0])
    assert "a blocking call of '/add' can never be answered: its callback " in text
    assert "write 'async def callback():' and in it 'answer = await client.call_async(request)'" in text


def test_a_call_works_inside_a_callback_of_another_group(make_node: MakeNode, spin: Spin) -> None:
    node, came = make_node(), Collector[Any]()
    group = MutuallyExclusiveCallbackGroup()
    node.create_service(AddTwoInts, 'add', add, callback_group=group)
    client = node.create_client(AddTwoInts, 'add')
    assert client.wait_for_service(PATIENCE)

    def callback() -> None:
        timer.cancel()
        came(client.call(Request(a=5)))

    timer = node.create_timer(0.001, callback)
    spin(node, threads=2)
    assert came.expect() == [Response(sum=5)]


def test_a_call_of_a_server_elsewhere_works_inside_a_callback(make_node: MakeNode, spin: Spin) -> None:
    server, node, came = make_node('server'), make_node(), Collector[Any]()
    server.create_service(AddTwoInts, 'add', add)
    client = node.create_client(AddTwoInts, 'add')
    assert client.wait_for_service(PATIENCE)

    def callback() -> None:
        timer.cancel()
        came(client.call(Request(a=6)))

    timer = node.create_timer(0.001, callback)
    spin(server)
    spin(node)
    assert came.expect() == [Response(sum=6)]


@pytest.mark.parametrize('kind', ['timer', 'subscription', 'service', 'done callback', 'task'])
def test_every_kind_of_callback_may_await_a_response(
    make_node: MakeNode, executor: Executor, kind: str
) -> None:
    servers, node, over = make_node('servers'), make_node(), Future[Any]()
    servers.create_service(AddTwoInts, 'add', add)
    client = node.create_client(AddTwoInts, 'add')
    assert client.wait_for_service(PATIENCE)
    executor.add_node(servers)
    executor.add_node(node)

    async def ask(*_: object) -> Any:
        if not over.done():
            over.set_result(await client.call_async(Request(a=2, b=2)))

    async def answer(request: Any, response: Any) -> Any:
        await ask()
        return response

    if kind == 'timer':
        node.create_timer(0.01, ask)
    elif kind == 'subscription':
        node.create_subscription(String, 'go', ask, 1)
        publisher = node.create_publisher(String, 'go', 1)
        node.create_timer(0.01, lambda: publisher.publish(String()), ReentrantCallbackGroup())
    elif kind == 'service':
        node.create_service(Trigger, 'go', answer)
        starter = servers.create_client(Trigger, 'go')
        assert starter.wait_for_service(PATIENCE)
        _ = starter.call_async(Trigger.Request())
    elif kind == 'done callback':
        first = client.call_async(Request())
        first.add_done_callback(ask)
    else:
        _ = executor.create_task(ask)
    executor.spin_until_future_complete(over, PATIENCE)
    assert over.result() == Response(sum=4)


def test_spinning_inside_a_callback_until_a_response_is_there(
    make_node: MakeNode, executor: Executor
) -> None:
    node, over = make_node(), Future[Any]()
    node.create_service(AddTwoInts, 'add', add)
    client = node.create_client(AddTwoInts, 'add')
    assert client.wait_for_service(PATIENCE)

    def callback() -> None:
        timer.cancel()
        future = client.call_async(Request(a=3))
        executor.spin_until_future_complete(future, PATIENCE)
        over.set_result(future.result())

    timer = node.create_timer(0.001, callback)
    executor.add_node(node)
    executor.spin_until_future_complete(over, PATIENCE)
    assert over.result() == Response(sum=3)
    assert node in executor.get_nodes()


def test_many_requests_in_flight_are_all_answered(make_node: MakeNode, spin: Spin) -> None:
    server = make_node('server')
    server.create_service(AddTwoInts, 'add', add)
    clients = [make_node(f'node{number}').create_client(AddTwoInts, 'add') for number in range(10)]
    assert all(client.wait_for_service(PATIENCE) for client in clients)
    spin(server)
    futures = [
        (number, client.call_async(Request(a=number, b=step)), step)
        for step in range(32)
        for number, client in enumerate(clients)
    ]
    for number, future, step in futures:
        assert result_of(future).sum == number + step
