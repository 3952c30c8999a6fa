"""Execution rule 3: what blocks completes on the thread that waits, whichever executor and groups there are.

It raises at once only where the callback that would have to answer needs the very thread or group that waits.
A callback that asks and the server that answers it, in each place and group, by each form of a call.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import Any, TypeAlias

import pytest
from example_interfaces.action import Fibonacci
from helpers.collector import Collector
from helpers.patience import PATIENCE
from helpers.spinning import MakeNode, Spinner
from rclpy.action import ActionClient, ActionServer
from rclpy.action.server import CancelResponse
from rclpy.callback_groups import CallbackGroup, MutuallyExclusiveCallbackGroup, ReentrantCallbackGroup
from rclpy.context import Context
from rclpy.executors import Executor, MultiThreadedExecutor, SingleThreadedExecutor
from rclpy.experimental.events_executor import EventsExecutor
from rclpy.node import Node
from std_srvs.srv import Trigger

from goalwire.errors import DeadlineError, WouldDeadlockError

EXECUTORS: dict[str, Callable[[Context], Executor]] = {
    'single': lambda context: SingleThreadedExecutor(context=context),
    'multi': lambda context: MultiThreadedExecutor(4, context=context),
    'events': lambda context: EventsExecutor(context=context),
}
GROUPS = ('same', 'other', 'reentrant')
ANSWER, RAISE = 'answer', 'raise'


def answer(_: Trigger.Request, response: Trigger.Response) -> Trigger.Response:
    response.success = True
    return response


def execute(handle: Any) -> Fibonacci.Result:
    handle.succeed()
    return Fibonacci.Result(sequence=[1])


class Asker:
    """A node that asks in a timer's callback; a server of everything that it asks for is in `server`."""

    def __init__(self, node: Node, server: Node, group: CallbackGroup, servers: CallbackGroup) -> None:
        self.node = node
        self.group = group
        server.create_service(Trigger, 'lamp', answer, callback_group=servers)
        ActionServer(
            server,
            Fibonacci,
            'arm',
            execute,
            callback_group=servers,
            cancel_callback=lambda _: CancelResponse.ACCEPT,
        )
        self.client = node.create_client(Trigger, 'lamp', callback_group=group)
        self.moving = ActionClient(node, Fibonacci, 'arm', callback_group=group)
        assert self.client.wait_for_service(PATIENCE)
        assert self.moving.wait_for_server(PATIENCE)
        self.outcomes: Collector[object] = Collector()

    def ask(self, form: Callable[[Asker], object]) -> None:
        """Ask in a callback, once, and note what came of it."""

        def callback() -> None:
            timer.cancel()
            try:
                self.outcomes(form(self))
            except WouldDeadlockError:
                self.outcomes(RAISE)

        timer = self.node.create_timer(0.001, callback, self.group)


def call(asker: Asker) -> str:
    response = asker.client.call(Trigger.Request())
    assert response is not None
    assert response.success
    return ANSWER


def send_goal(asker: Asker) -> str:
    response = asker.moving.send_goal(Fibonacci.Goal())
    assert response is not None
    assert list(response.result.sequence) == [1]
    return ANSWER


def get_result(asker: Asker) -> str:
    handle = asker.moving.blocking.wait_for(lambda: asker.moving.send_goal_async(Fibonacci.Goal()))
    assert handle.get_result() is not None
    assert handle.cancel_goal() is not None
    return ANSWER


def spin_until_future_complete(asker: Asker) -> str:
    """Spin for the answer, as programs do in places where rclpy's `call` would hang."""
    executor = asker.node.executor
    assert executor is not None
    future = asker.client.call_async(Trigger.Request())
    executor.spin_until_future_complete(future, PATIENCE)
    response = future.result()
    assert response is not None
    assert asker.node in executor.get_nodes()
    return ANSWER


Form: TypeAlias = Callable[[Asker], str]
BLOCKING: tuple[Form, ...] = (call, send_goal, get_result)


@pytest.fixture(params=EXECUTORS)
def kind(request: pytest.FixtureRequest) -> str:
    name: str = request.param
    return name


@pytest.fixture
def run(context: Context) -> Iterator[Callable[..., Spinner]]:
    """Spin nodes in an executor of a kind."""
    spinners: list[Spinner] = []

    def start(kind: str, *nodes: Node) -> Spinner:
        spinners.append(Spinner(EXECUTORS[kind](context), *nodes))
        return spinners[-1]

    yield start
    for spinner in spinners:
        spinner.close()
        assert spinner.raised.items == []


def grouped(groups: str) -> tuple[CallbackGroup, CallbackGroup]:
    """The group of who asks, and that of the servers."""
    asking: CallbackGroup = (
        ReentrantCallbackGroup() if groups == 'reentrant' else MutuallyExclusiveCallbackGroup()
    )
    return asking, MutuallyExclusiveCallbackGroup() if groups == 'other' else asking


@pytest.mark.parametrize('form', BLOCKING)
@pytest.mark.parametrize('groups', GROUPS)
def test_a_call_of_a_server_in_the_same_node(
    make_node: MakeNode, run: Callable[..., Spinner], kind: str, groups: str, form: Form
) -> None:
    """One thread cannot do both; several can, unless the group that the callback holds is the server's."""
    node = make_node()
    asker = Asker(node, node, *grouped(groups))
    asker.ask(form)
    run(kind, node)
    possible = kind == 'multi' and groups != 'same'
    assert asker.outcomes.expect(1) == [ANSWER if possible else RAISE]


@pytest.mark.parametrize('form', BLOCKING)
@pytest.mark.parametrize('groups', ['same', 'reentrant'])
def test_a_call_of_a_server_in_another_executor(
    make_node: MakeNode, run: Callable[..., Spinner], kind: str, groups: str, form: Form
) -> None:
    node, server = make_node(), make_node('server')
    asking, _ = grouped(groups)
    asker = Asker(node, server, asking, MutuallyExclusiveCallbackGroup())
    asker.ask(form)
    run('single', server)
    run(kind, node)
    assert asker.outcomes.expect(1) == [ANSWER]


@pytest.mark.parametrize('form', BLOCKING)
def test_a_call_of_a_node_that_nobody_spins(
    make_node: MakeNode, run: Callable[..., Spinner], kind: str, form: Form
) -> None:
    """Its own executor is not needed: the answer completes the call on the thread that waits."""
    node, server = make_node(), make_node('server')
    asker = Asker(node, server, *grouped('other'))
    run(kind, server)
    assert form(asker) == ANSWER


@pytest.mark.parametrize('groups', GROUPS)
def test_spinning_in_a_callback_until_an_answer_is_there(
    make_node: MakeNode, run: Callable[..., Spinner], kind: str, groups: str
) -> None:
    node = make_node()
    asker = Asker(node, node, *grouped(groups))
    asker.ask(spin_until_future_complete)
    run(kind, node)
    assert asker.outcomes.expect(1) == [ANSWER]


def test_two_nodes_that_wait_for_each_other_end_by_their_deadlines(
    make_node: MakeNode, run: Callable[..., Spinner], kind: str
) -> None:
    """Each in an executor of its own, as in two processes: nobody can see the circle."""
    names = ('left', 'right')
    nodes = {name: make_node(name) for name in names}
    clients = {
        name: nodes[name].create_client(Trigger, other)
        for name, other in zip(names, names[::-1], strict=True)
    }
    ended: Collector[type[BaseException]] = Collector()

    def serve(name: str) -> None:
        def ask_back(_: Trigger.Request, response: Trigger.Response) -> Trigger.Response:
            try:
                clients[name].call(Trigger.Request())
            except DeadlineError as error:
                ended(type(error))
            return response

        nodes[name].create_service(Trigger, name, ask_back)
        clients[name].call_timeout = 0.1

    for name in names:
        serve(name)
    outside = make_node('outside').create_client(Trigger, 'left')
    for client in (*clients.values(), outside):
        assert client.wait_for_service(PATIENCE)
    for node in nodes.values():
        run(kind, node)
    assert outside.call(Trigger.Request(), PATIENCE) is not None
    assert ended.expect(1)[0] is DeadlineError
