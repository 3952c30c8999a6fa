"""In which order a program hears of a goal: executed, accepted, feedback, result.

Where server and client share an executor, the execution begins before the client learns of the acceptance.
"""

from __future__ import annotations

import threading
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

import pytest
from example_interfaces.action import Fibonacci
from helpers.actions import Feedback, Goal, Result
from helpers.collector import Collector
from helpers.patience import PATIENCE
from helpers.spinning import MakeNode, Spin, Spinner, result_of, wait_until
from rclpy.action import ActionClient, ActionServer
from rclpy.action.client import ClientGoalHandle
from rclpy.action.server import ServerGoalHandle
from rclpy.callback_groups import MutuallyExclusiveCallbackGroup, ReentrantCallbackGroup
from rclpy.context import Context
from rclpy.exceptions import InvalidHandle
from rclpy.executors import Executor, MultiThreadedExecutor, SingleThreadedExecutor
from rclpy.node import Node
from rclpy.task import Future

from goalwire.errors import ShutDownError

pytestmark = pytest.mark.also_on_dds

ROUNDS = 20
MESSAGES = 5


class Telling:
    """A server that publishes feedback as fast as it can, and a client that writes down what it hears."""

    def __init__(self, server_node: Node, client_node: Node, client_group: Any = None) -> None:
        self.trace: list[object] = []
        self.done_before: list[bool] = []
        """For each goal: whether its future was done before its execution began."""
        self.sending: Future[Any] | None = None
        self.over: Future[None] = Future()
        ActionServer(server_node, Fibonacci, 'tell', self._execute, callback_group=ReentrantCallbackGroup())
        self.client = ActionClient(client_node, Fibonacci, 'tell', callback_group=client_group)
        assert self.client.wait_for_server(PATIENCE)
        wait_until(client_node.context, lambda: server_node.count_subscribers('tell/_action/feedback') == 1)

    def _execute(self, handle: ServerGoalHandle) -> Fibonacci.Result:
        self.done_before.append(self.sending is not None and self.sending.done())
        self.trace.append('executed')
        for number in range(MESSAGES):
            handle.publish_feedback(Feedback(sequence=[number]))
        handle.succeed()
        return Result()

    def send(self) -> None:
        """Send a goal; `over` is done with the done callback of its result."""
        self.trace.clear()
        self.sending, self.over = None, Future()
        self.sending = sending = self.client.send_goal_async(
            Goal(), lambda message: self.trace.extend(message.feedback.sequence)
        )
        sending.add_done_callback(self._accepted)

    def _accepted(self, sending: Future[Any]) -> None:
        self.trace.append('accepted')
        result_of(sending).get_result_async().add_done_callback(self._ended)

    def _ended(self, result: Future[Any]) -> None:
        self.trace.append('ended')
        self.over.set_result(None)


@contextmanager
def spun(context: Context, threads: int, *nodes: Node) -> Iterator[Executor]:
    """Yield an executor that has the nodes."""
    executor = (
        SingleThreadedExecutor(context=context)
        if threads == 1
        else MultiThreadedExecutor(threads, context=context)
    )
    with executor:
        for node in nodes:
            executor.add_node(node)
        yield executor


@pytest.mark.parametrize('nodes', [1, 2])
def test_one_thread_hears_of_a_goal_in_order(context: Context, make_node: MakeNode, nodes: int) -> None:
    server = make_node('server')
    client = server if nodes == 1 else make_node('client')
    telling = Telling(server, client)
    with spun(context, 1, *{server: None, client: None}) as executor:
        for _ in range(ROUNDS):
            telling.send()
            executor.spin_until_future_complete(telling.over, PATIENCE)
            assert telling.trace == ['executed', 'accepted', *range(MESSAGES), 'ended']
    assert not any(telling.done_before)


@pytest.mark.parametrize('reentrant', [False, True], ids=['exclusive', 'reentrant'])
def test_many_threads_hear_of_the_result_after_all_feedback(
    context: Context, make_node: MakeNode, reentrant: bool
) -> None:
    server, client = make_node('server'), make_node('client')
    telling = Telling(server, client, ReentrantCallbackGroup() if reentrant else None)
    with spun(context, 4, server, client) as executor:
        for _ in range(ROUNDS):
            telling.send()
            executor.spin_until_future_complete(telling.over, PATIENCE)
            heard = [item for item in telling.trace if isinstance(item, int)]
            assert sorted(heard) == list(range(MESSAGES))
            assert reentrant or heard == sorted(heard)
            assert telling.trace[-1] == 'ended'


@pytest.mark.parametrize('threads', [1, 4])
def test_the_client_in_an_executor_of_its_own_hears_in_order(
    context: Context, make_node: MakeNode, spin: Spin, threads: int
) -> None:
    server, client = make_node('server'), make_node('client')
    telling = Telling(server, client)
    spin(server, threads=threads)
    with spun(context, 1, client) as executor:
        for _ in range(ROUNDS):
            telling.send()
            executor.spin_until_future_complete(telling.over, PATIENCE)
            heard = [item for item in telling.trace if item != 'executed']
            assert heard == ['accepted', *range(MESSAGES), 'ended']


def test_spinning_once_at_a_time_hears_in_order(context: Context, make_node: MakeNode) -> None:
    node = make_node()
    telling = Telling(node, node)
    with spun(context, 1, node) as executor:
        telling.send()
        while not telling.over.done():
            executor.spin_once(timeout_sec=PATIENCE)
    assert telling.trace == ['executed', 'accepted', *range(MESSAGES), 'ended']
    assert telling.done_before == [False]


# -- a server by hand, whose messages overtake each other ------------------------------------------------


class ByHand:
    """Answers in whatever order `accept` and `finish` say: services and a topic of their own."""

    def __init__(self, node: Node) -> None:
        impl = Fibonacci.Impl
        self.accept = threading.Event()
        self.goal_id: Any = None
        self._message = impl.FeedbackMessage
        self._feedback = node.create_publisher(impl.FeedbackMessage, 'tell/_action/feedback', 10)
        self.early: list[int] = []
        self.late: list[int] = []
        self.asked = Collector[str]()
        group = ReentrantCallbackGroup()
        node.create_service(impl.SendGoalService, 'tell/_action/send_goal', self._take, callback_group=group)
        node.create_service(
            impl.GetResultService, 'tell/_action/get_result', self._answer, callback_group=group
        )
        self.finish = threading.Event()

    def publish(self, *numbers: int) -> None:
        """Publish feedback for the goal that was taken last."""
        for number in numbers:
            message = self._message(goal_id=self.goal_id, feedback=Feedback(sequence=[number]))
            self._feedback.publish(message)

    def _take(self, request: Any, response: Any) -> Any:
        self.goal_id = request.goal_id
        self.asked('goal')
        assert self.accept.wait(PATIENCE)
        response.accepted = True
        return response

    def _answer(self, _request: Any, response: Any) -> Any:
        self.asked('result')
        assert self.finish.wait(PATIENCE)
        response.status = 4
        return response


@pytest.fixture
def by_hand(context: Context, make_node: MakeNode, spin: Spin) -> ByHand:
    node = make_node('by_hand')
    server = ByHand(node)
    spin(node, threads=4)
    return server


def client_of(by_hand: ByHand, node: Node, **options: Any) -> ActionClient[Any, Any, Any]:
    """Make a client whose server and feedback are matched."""
    client = ActionClient(node, Fibonacci, 'tell', **options)
    wait_until(node.context, lambda: node.count_services('tell/_action/get_result') == 1)
    wait_until(node.context, lambda: node.count_services('tell/_action/send_goal') == 1)
    wait_until(node.context, lambda: by_hand._feedback.get_subscription_count() == 1)
    return client


def turn_of(spinner: Spinner) -> None:
    """Wait until the one thread of a spinner has run all that was there before."""
    assert result_of(spinner.executor.create_task(lambda: True))


def test_feedback_that_overtakes_the_acceptance_waits_for_it(
    make_node: MakeNode, spin: Spin, by_hand: ByHand
) -> None:
    node, trace = make_node(), Collector[object]()
    client = client_of(by_hand, node)
    spinner = spin(node)
    sending = client.send_goal_async(Goal(), lambda message: trace(message.feedback.sequence[0]))
    sending.add_done_callback(lambda _: trace('accepted'))
    by_hand.asked.expect(1)
    by_hand.publish(1, 2, 3)
    turn_of(spinner)
    assert trace.items == []
    by_hand.accept.set()
    assert trace.expect(4) == ['accepted', 1, 2, 3]


def test_feedback_after_the_result_is_not_heard(make_node: MakeNode, spin: Spin, by_hand: ByHand) -> None:
    node, heard = make_node(), Collector[int]()
    client = client_of(by_hand, node)
    spinner = spin(node)
    by_hand.accept.set()
    by_hand.finish.set()
    handle: ClientGoalHandle = result_of(
        client.send_goal_async(Goal(), lambda message: heard(message.feedback.sequence[0]))
    )
    by_hand.publish(1)
    heard.expect(1)
    assert result_of(handle.get_result_async()).status == 4
    by_hand.publish(2)
    assert client.statistics().feedback == 2
    turn_of(spinner)
    assert heard.items == [1]


def test_a_result_does_not_wait_where_nobody_spins(make_node: MakeNode, by_hand: ByHand) -> None:
    node = make_node()
    client = client_of(by_hand, node)
    by_hand.accept.set()
    handle: ClientGoalHandle = result_of(client.send_goal_async(Goal(), lambda _: None))
    by_hand.publish(1, 2)
    by_hand.finish.set()
    with SingleThreadedExecutor(context=node.context) as executor:
        executor.add_node(node)  # and nobody spins it
        answer = handle.get_result()
        assert answer is not None
        assert answer.status == 4


@pytest.mark.parametrize('form', ['await', 'await in a task', 'block'])
@pytest.mark.parametrize('threads', [1, 4])
def test_a_callback_that_holds_the_group_of_the_feedback_gets_the_result(
    make_node: MakeNode, spin: Spin, by_hand: ByHand, form: str, threads: int
) -> None:
    """It keeps the feedback callbacks waiting: for them to run first, it would have to end."""
    import asyncio

    node, heard = make_node(), Collector[object]()
    group = MutuallyExclusiveCallbackGroup()
    client = client_of(by_hand, node, callback_group=group)
    by_hand.accept.set()
    handle: ClientGoalHandle = result_of(
        client.send_goal_async(Goal(), lambda message: heard(message.feedback.sequence[0]))
    )

    def now() -> None:
        timer.cancel()
        by_hand.publish(1, 2)
        by_hand.finish.set()

    async def wait() -> None:
        now()
        if form == 'await':
            await handle.get_result_async()
        else:

            async def inner() -> None:
                await handle.get_result_async()

            await asyncio.create_task(inner())
        heard('result')

    def block() -> None:
        now()
        handle.get_result()
        heard('result')

    timer = node.create_timer(0.001, block if form == 'block' else wait, callback_group=group)
    spin(node, threads=threads)
    assert 'result' in heard.wait_for(lambda items: {'result', 1, 2} <= set(items))


def test_a_feedback_callback_may_wait_for_the_result(
    make_node: MakeNode, spin: Spin, by_hand: ByHand
) -> None:
    node, heard = make_node(), Collector[object]()
    client = client_of(by_hand, node)
    handle: Future[ClientGoalHandle] = Future()

    async def hear(message: Any) -> None:
        by_hand.finish.set()
        answer = await result_of(handle).get_result_async()
        heard(answer and answer.status)

    spin(node)
    by_hand.accept.set()
    handle.set_result(result_of(client.send_goal_async(Goal(), hear)))
    by_hand.publish(1)
    assert heard.expect(1) == [4]


def test_a_raising_feedback_callback_does_not_keep_the_result(
    make_node: MakeNode, spin: Spin, by_hand: ByHand
) -> None:
    def fail(_: object) -> None:
        raise ZeroDivisionError

    node = make_node()
    client = client_of(by_hand, node, callback_group=ReentrantCallbackGroup())
    by_hand.accept.set()
    spinner = spin(node)
    handle: ClientGoalHandle = result_of(client.send_goal_async(Goal(), fail))
    by_hand.publish(1)
    spinner.expect_raised(ZeroDivisionError)
    by_hand.finish.set()
    assert result_of(handle.get_result_async()).status == 4


def test_a_client_that_is_destroyed_keeps_no_result_back(
    make_node: MakeNode, spin: Spin, by_hand: ByHand
) -> None:
    node = make_node()
    client = client_of(by_hand, node)
    by_hand.accept.set()
    handle: ClientGoalHandle = result_of(client.send_goal_async(Goal(), lambda _: None))
    by_hand.publish(1)
    result = handle.get_result_async()
    by_hand.finish.set()
    client.destroy()
    assert not result.done()
    spinner = spin(node)
    turn_of(spinner)


# -- the end while somebody waits ------------------------------------------------------------------------


@pytest.mark.parametrize('accepted', [False, True], ids=['sent', 'accepted'])
@pytest.mark.parametrize('end', ['context', 'client', 'node'])
def test_a_thread_that_waits_for_a_goal_gets_an_error_at_the_end_and_no_none(
    context: Context, make_node: MakeNode, by_hand: ByHand, accepted: bool, end: str
) -> None:
    node, outcome = make_node(), Collector[object]()
    client = client_of(by_hand, node)

    def wait() -> None:
        try:
            outcome(client.send_goal(Goal()))
        except (InvalidHandle, ShutDownError) as error:
            outcome(type(error).__name__)

    thread = threading.Thread(target=wait)
    thread.start()
    by_hand.asked.expect(1)
    if accepted:
        by_hand.accept.set()
        by_hand.asked.expect(2)
    if end == 'context':
        context.shutdown_signal.end('SIGTERM')
    elif end == 'client':
        client.destroy()
    else:
        node.destroy_node()
    assert outcome.expect(1) == ['ShutDownBySignalError' if end == 'context' else 'InvalidHandle']
    thread.join(PATIENCE)
    by_hand.accept.set()
    by_hand.finish.set()
