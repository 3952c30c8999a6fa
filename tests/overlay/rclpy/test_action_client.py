"""Action clients: goals, feedback and results."""

from __future__ import annotations

import threading
import time
from typing import Any, TypeVar

import pytest
from action_msgs.msg import GoalStatusArray
from action_msgs.srv import CancelGoal
from example_interfaces.action import Fibonacci
from helpers.actions import NAMES, Arena, Feedback, Gate, Goal, Patient, Result, accept_cancel, id_of, succeed
from helpers.collector import Collector
from helpers.patience import PATIENCE
from helpers.processes import Program
from helpers.spinning import MakeNode, Spin, result_of, wait_until
from rclpy.action import ActionClient, ActionServer
from rclpy.action.server import ServerGoalHandle
from rclpy.callback_groups import ReentrantCallbackGroup
from rclpy.context import Context
from rclpy.exceptions import InvalidHandle
from rclpy.executors import Executor
from unique_identifier_msgs.msg import UUID

from goalwire.errors import EncodeError, GoalIdTaken, WouldDeadlockError
from goalwire.execution.event_queue import EventQueue

pytestmark = pytest.mark.also_on_dds

T = TypeVar('T')

Handle = ServerGoalHandle
NONE, GOAL_TERMINATED = 0, 3


def given(answer: T | None) -> T:
    """The answer, which a blocking call gives unless its context has ended."""
    assert answer is not None
    return answer


@pytest.fixture
def patient() -> Patient:
    return Patient()


@pytest.fixture
def arena(make_node: MakeNode, spin: Spin, patient: Patient) -> Arena:
    return Arena(make_node, spin, patient, threads=6, cancel=accept_cancel)


def test_spin_once_returns_for_each_answer_that_only_a_loop_looks_at(
    make_node: MakeNode, spin: Spin, executor: Executor
) -> None:
    server, node = make_node('server'), make_node()
    spin(server)
    ActionServer(server, Fibonacci, 'fibonacci', succeed)
    client = ActionClient(node, Fibonacci, 'fibonacci')
    assert client.wait_for_server(PATIENCE)
    executor.add_node(node)
    begun = time.monotonic()
    sent = client.send_goal_async(Goal(order=3))
    while not sent.done():
        executor.spin_once(timeout_sec=PATIENCE)
    result = given(sent.result()).get_result_async()
    while not result.done():
        executor.spin_once(timeout_sec=PATIENCE)
    cancelled = given(sent.result()).cancel_goal_async()
    while not cancelled.done():
        executor.spin_once(timeout_sec=PATIENCE)
    assert given(cancelled.result()).return_code == GOAL_TERMINATED
    assert time.monotonic() - begun < PATIENCE


# -- feedback --------------------------------------------------------------------------------------------


def test_feedback_goes_to_the_callback_of_its_own_goal(make_node: MakeNode, spin: Spin) -> None:
    def execute(handle: Handle) -> Fibonacci.Result:
        for _ in range(5):
            handle.publish_feedback(Feedback(sequence=[handle.request.order]))
        return succeed(handle)

    arena = Arena(make_node, spin, execute)
    heard: list[Collector[Any]] = [Collector() for _ in range(4)]
    futures = [
        arena.client.send_goal_async(Goal(order=order), feedback_callback=callback)
        for order, callback in enumerate(heard)
    ]
    ids = [id_of(result_of(future)) for future in futures]
    for order, callback in enumerate(heard):
        messages = callback.expect(5)
        assert [list(message.feedback.sequence) for message in messages] == [[order]] * 5
        assert {bytes(message.goal_id.uuid) for message in messages} == {ids[order]}


def test_of_feedback_that_nobody_takes_the_newest_thousand_wait(
    context: Context, make_node: MakeNode, spin: Spin, executor: Executor
) -> None:
    def execute(handle: Handle) -> Fibonacci.Result:
        for number in range(1200):
            handle.publish_feedback(Feedback(sequence=[number]))
        return succeed(handle)

    server, node = make_node('server'), make_node()
    ActionServer(server, Fibonacci, 'fib', execute)
    client = ActionClient(node, Fibonacci, 'fib')
    assert client.wait_for_server(PATIENCE)
    wait_until(context, lambda: server.count_subscribers('fib/_action/feedback') == 1)
    spin(server)
    heard: list[int] = []
    last = threading.Event()

    def hear(message: Any) -> None:
        heard.append(message.feedback.sequence[0])
        if heard[-1] == 1199:
            last.set()

    handle = result_of(client.send_goal_async(Goal(), hear))
    result_of(handle.get_result_async())
    event_queue = client.goals.ended[id_of(handle)].feedback
    assert isinstance(event_queue, EventQueue)
    node.create_timer(0.001, lambda: None)
    executor.add_node(node)
    while not last.is_set():
        executor.spin_once(timeout_sec=PATIENCE)
    assert heard == sorted(heard)
    # The mark of the goal's end waits in the same queue, and may take the place of the oldest.
    assert heard[-999:] == list(range(201, 1200))
    assert len(heard) + event_queue.dropped == 1200


def test_a_feedback_callback_that_raises_comes_out_of_spin(make_node: MakeNode, spin: Spin) -> None:
    def execute(handle: Handle) -> Fibonacci.Result:
        handle.publish_feedback(Feedback())
        return succeed(handle)

    def hear(message: Any) -> None:
        raise ZeroDivisionError

    arena = Arena(make_node, spin, execute)
    handle = result_of(arena.client.send_goal_async(Goal(order=2), hear))
    assert arena.result(handle) == ('SUCCEEDED', [2])
    arena.spinner.expect_raised(ZeroDivisionError)


# -- goals -----------------------------------------------------------------------------------------------


def test_a_goal_handle_tells_about_its_goal(make_node: MakeNode, spin: Spin) -> None:
    arena = Arena(make_node, spin, succeed)
    handle, other = arena.accept(), arena.accept()
    arena.result(handle)
    assert handle.accepted is True
    assert NAMES[handle.status] == 'SUCCEEDED'
    assert handle.stamp.sec > 0
    assert handle == handle  # noqa: PLR0124
    assert handle != other
    assert handle != 5
    assert repr(handle).startswith('ClientGoalHandle <id=[')
    assert repr(handle).endswith('accepted=True, status=4>')
    with pytest.raises(TypeError, match='unhashable'):
        hash(handle)


@pytest.mark.parametrize('wrong', [1, None, Result(), Goal], ids=repr)
def test_only_goals_of_the_action_are_sent(make_node: MakeNode, wrong: Any) -> None:
    client = ActionClient(make_node(), Fibonacci, 'fib')
    with pytest.raises(TypeError, match=r'^expected .*Fibonacci\.Goal'):
        _ = client.send_goal_async(wrong)
    with pytest.raises(TypeError, match=r'^expected .*Fibonacci\.Goal'):
        client.send_goal(wrong)


def test_a_goal_that_cannot_go_on_the_wire_is_named(make_node: MakeNode) -> None:
    client = ActionClient(make_node(), Fibonacci, 'fib')
    goal = Goal()
    goal.order = 'x'  # type: ignore[assignment]
    with pytest.raises(EncodeError, match=r"Fibonacci_Goal: order: .*'x'"):
        _ = client.send_goal_async(goal)
    with pytest.raises(AttributeError, match='uuid'):
        _ = client.send_goal_async(Goal(), goal_uuid=5)  # type: ignore[call-overload]
    assert client.goals.active == {}


def test_an_id_under_way_is_not_sent_again(make_node: MakeNode, spin: Spin) -> None:
    kept: Collector[Handle] = Collector()
    arena = Arena(make_node, spin, succeed, accepted=kept)
    goal_id = UUID(uuid=[7] * 16)
    arena.accept(1, goal_id)
    with pytest.raises(GoalIdTaken, match='07070707'):
        _ = arena.client.send_goal_async(Goal(), goal_uuid=goal_id)


def test_blocking_calls_need_no_executor(make_node: MakeNode, spin: Spin) -> None:
    gate = Gate()

    def execute(handle: Handle) -> Fibonacci.Result:
        gate(handle)
        handle.canceled()
        return Result(sequence=[1])

    server, node = make_node('server'), make_node()
    ActionServer(
        server, Fibonacci, 'fib', execute, cancel_callback=accept_cancel,
        callback_group=ReentrantCallbackGroup(),
    )  # fmt: skip
    client = ActionClient(node, Fibonacci, 'fib')
    assert client.wait_for_server(PATIENCE)
    spin(server, threads=4)
    handle = result_of(client.send_goal_async(Goal()))
    gate.reached.expect()
    assert given(handle.cancel_goal()).return_code == NONE
    gate.open()
    assert NAMES[given(handle.get_result()).status] == 'CANCELED'
    assert given(handle.cancel_goal()).return_code == GOAL_TERMINATED


def test_send_goal_waits_for_the_result(make_node: MakeNode, spin: Spin) -> None:
    server, node = make_node('server'), make_node()
    ActionServer(server, Fibonacci, 'fib', succeed)
    client = ActionClient(node, Fibonacci, 'fib')
    assert client.wait_for_server(PATIENCE)
    spin(server)
    response = given(client.send_goal(Goal(order=5)))
    assert NAMES[response.status] == 'SUCCEEDED'
    assert list(response.result.sequence) == [5]


def test_send_goal_where_the_own_thread_would_have_to_execute_raises_at_once(
    make_node: MakeNode, spin: Spin
) -> None:
    node, raised = make_node(), Collector[BaseException]()
    ActionServer(node, Fibonacci, 'fib', succeed)
    client = ActionClient(node, Fibonacci, 'fib')
    assert client.wait_for_server(PATIENCE)

    def callback() -> None:
        timer.cancel()
        try:
            client.send_goal(Goal())
        except WouldDeadlockError as error:
            raised(error)

    timer = node.create_timer(0.001, callback)
    spin(node)
    assert 'can never be answered' in str(raised.expect()[0])


def test_send_goal_inside_a_callback_works_where_others_execute(make_node: MakeNode, spin: Spin) -> None:
    server, node, came = make_node('server'), make_node(), Collector[Any]()
    ActionServer(server, Fibonacci, 'fib', succeed)
    client = ActionClient(node, Fibonacci, 'fib')
    assert client.wait_for_server(PATIENCE)

    def callback() -> None:
        timer.cancel()
        came(client.send_goal(Goal(order=8)))

    timer = node.create_timer(0.001, callback)
    spin(server)
    spin(node)
    assert list(came.expect()[0].result.sequence) == [8]


def test_awaiting_a_whole_goal_in_a_callback(make_node: MakeNode, executor: Executor) -> None:
    server, node, came = make_node('server'), make_node(), Collector[Any]()
    ActionServer(server, Fibonacci, 'fib', succeed)
    client = ActionClient(node, Fibonacci, 'fib')
    assert client.wait_for_server(PATIENCE)
    from rclpy.task import Future

    done = Future[Any]()

    async def callback() -> None:
        timer.cancel()
        handle = await client.send_goal_async(Goal(order=3))
        assert handle is not None
        response = await handle.get_result_async()
        came(response)
        done.set_result(True)

    timer = node.create_timer(0.001, callback)
    executor.add_node(server)
    executor.add_node(node)
    executor.spin_until_future_complete(done, PATIENCE)
    assert list(came.items[0].result.sequence) == [3]


# -- servers that come, go, and are two ------------------------------------------------------------------


def test_a_client_waits_for_a_server_that_starts_later(make_node: MakeNode, spin: Spin) -> None:
    node, ready = make_node(), Collector[bool]()
    client = ActionClient(node, Fibonacci, 'fib')
    assert client.server_is_ready() is False
    assert client.wait_for_server(0) is False
    assert client.wait_for_server(timeout_sec=0.05) is False
    thread = threading.Thread(target=lambda: ready(client.wait_for_server(PATIENCE)))
    thread.start()
    server = make_node('server')
    ActionServer(server, Fibonacci, 'fib', succeed)
    assert ready.expect() == [True]
    thread.join()
    assert client.server_is_ready() is True


def test_a_goal_for_nobody_stays_pending_and_is_logged_once(
    make_node: MakeNode, spin: Spin, monkeypatch: pytest.MonkeyPatch
) -> None:
    node, said = make_node(), Collector[str]()
    client = ActionClient(node, Fibonacci, 'nosuch')
    monkeypatch.setattr(client.logger, 'warning', said)
    futures = [client.send_goal_async(Goal()) for _ in range(3)]
    assert "Action 'nosuch': no server answered the goal" in said.expect()[0]
    assert not any(future.done() or future.cancelled() for future in futures)


def test_with_two_servers_the_first_answer_counts(make_node: MakeNode, spin: Spin, monkeypatch: Any) -> None:
    one, two, node, said = make_node('one'), make_node('two'), make_node(), Collector[str]()
    context = node.context
    for server in (one, two):
        ActionServer(server, Fibonacci, 'fib', succeed)
    client = ActionClient(node, Fibonacci, 'fib')
    monkeypatch.setattr(client.logger, 'warning', said)
    wait_until(context, lambda: node.count_services('fib/_action/send_goal') == 2)
    spin(one)
    spin(two)
    spin(node)
    handle = result_of(client.send_goal_async(Goal(order=6)))
    assert list(result_of(handle.get_result_async()).result.sequence) == [6]
    assert 'Ignoring unexpected goal response' in said.expect()[0]


def test_a_destroyed_client_refuses_to_work(make_node: MakeNode) -> None:
    node = make_node()
    client = ActionClient(node, Fibonacci, 'fib')
    pending = client.send_goal_async(Goal())
    client.destroy()
    client.destroy()
    assert client.server_is_ready() is False
    assert (pending.done(), pending.cancelled()) == (False, False)
    with pytest.raises(InvalidHandle):
        _ = client.send_goal_async(Goal())
    assert list(node.waitables) == []
    assert client.wait_for_server(0.01) is False


def test_a_client_destroyed_while_it_waits_leaves_the_server_alone(arena: Arena, patient: Patient) -> None:
    handle = arena.accept(3)
    result = handle.get_result_async()
    patient.gate.reached.expect()
    arena.client.destroy()
    patient.gate.open()
    arena.seen(handle, 'SUCCEEDED')
    assert not result.done()
    assert not result.cancelled()


def test_wrong_arguments_are_refused_with_rclpys_exceptions(make_node: MakeNode) -> None:
    node = make_node()
    with pytest.raises(AttributeError, match='a class of a message, a service or an action is needed'):
        ActionClient(node, int, 'fib')  # type: ignore[arg-type]
    for wrong in (GoalStatusArray, CancelGoal):
        with pytest.raises(RuntimeError, match='action type provided is not valid'):
            ActionClient(node, wrong, 'fib')  # type: ignore[arg-type]
    with pytest.raises(ValueError, match=r"Failed to create action client.*'a b'"):
        ActionClient(node, Fibonacci, 'a b')
    with pytest.raises(ValueError, match='Failed to create action client'):
        ActionClient(node, Fibonacci, '')
    assert list(node.waitables) == []


def test_an_action_is_remapped_by_its_name_on_both_sides(context: Context, spin: Spin) -> None:
    from rclpy.node import Node

    rules = ['--ros-args', '-r', 'fib:=/robot/fib']
    server, node = Node('server', context=context, cli_args=rules), Node('client', context=context)
    action_server = ActionServer(server, Fibonacci, 'fib', succeed)
    client = ActionClient(node, Fibonacci, 'robot/fib')
    remapped = ActionClient(server, Fibonacci, 'fib')
    assert client.wait_for_server(PATIENCE)
    assert remapped.wait_for_server(PATIENCE)
    spin(server)
    assert list(given(client.send_goal(Goal(order=2))).result.sequence) == [2]
    action_server.destroy()


def test_a_blocking_send_that_could_never_end_sends_nothing(make_node: MakeNode, spin: Spin) -> None:
    node = make_node()
    executed: Collector[int] = Collector()

    def execute(handle: Handle) -> Fibonacci.Result:
        executed(handle.request.order)
        return succeed(handle)

    ActionServer(node, Fibonacci, 'fib', execute)
    client = ActionClient(node, Fibonacci, 'fib')
    assert client.wait_for_server(PATIENCE)
    raised: Collector[BaseException] = Collector()

    def call() -> None:
        timer.cancel()
        try:
            client.send_goal(Fibonacci.Goal(order=1))
        except WouldDeadlockError as error:
            raised(error)
            _ = client.send_goal_async(Fibonacci.Goal(order=2))

    timer = node.create_timer(0.0, call)
    spin(node)
    raised.expect(1)
    assert executed.expect(1) == [2]


def test_the_first_goal_waits_for_no_import(isolated: dict[str, str]) -> None:
    """A feedback message has a goal id, an array of numpy's: to import that takes 80 ms."""
    program = """
        import sys
        import rclpy
        from example_interfaces.action import Fibonacci
        from rclpy.action import ActionClient, ActionServer

        def execute(goal):
            goal.publish_feedback(Fibonacci.Feedback(sequence=[1]))
            goal.succeed()
            return Fibonacci.Result()

        with rclpy.init():
            node = rclpy.create_node('first')
            server = ActionServer(node, Fibonacci, 'count', execute)
            client = ActionClient(node, Fibonacci, 'count')
            client.wait_for_server()
            rclpy.spin_once(node, timeout_sec=0)
            before, fed = set(sys.modules), rclpy.Future()
            sent = client.send_goal_async(Fibonacci.Goal(order=1), feedback_callback=fed.set_result)
            rclpy.spin_until_future_complete(node, sent)
            rclpy.spin_until_future_complete(node, fed)
            rclpy.spin_until_future_complete(node, sent.result().get_result_async())
            assert list(fed.result().feedback.sequence) == [1]
            print([name for name in set(sys.modules) - before if 'numpy' in name])
    """
    with Program(program, env=isolated) as running:
        assert running.succeed() == '[]'
