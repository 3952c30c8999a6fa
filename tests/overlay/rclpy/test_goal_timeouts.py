"""Goals that end: a default time for acceptance and cancellation, and what programs written for rclpy get."""

from __future__ import annotations

import threading
from typing import Any

import pytest
from action_msgs.msg import GoalStatus
from example_interfaces.action import Fibonacci
from helpers.collector import Collector
from helpers.patience import PATIENCE, wait_for
from helpers.spinning import MakeNode, Spin, result_of, wait_until
from rclpy.action import ActionClient, ActionServer
from rclpy.action.server import ServerGoalHandle
from rclpy.callback_groups import ReentrantCallbackGroup
from rclpy.context import Context
from rclpy.exceptions import InvalidHandle
from rclpy.node import Node
from rclpy.task import Future

from goalwire.entities.actions import client_requests
from goalwire.errors import DeadlineError, NoServerError, ServerLostError, ShutDownError, TooManyCallsError
from goalwire.execution.time.steady_clock import STEADY

Goal = Fibonacci.Goal
FibonacciClient = ActionClient[Fibonacci.Goal, Fibonacci.Result, Fibonacci.Feedback]
Handle = ServerGoalHandle[Fibonacci.Goal, Fibonacci.Result, Fibonacci.Feedback]


def error_of(future: Future[Any]) -> BaseException:
    """Wait for the exception that a future ends with."""
    assert future.wait(STEADY.now() + int(PATIENCE * 1e9)), 'it stays pending'
    error = future.exception()
    assert error is not None
    return error


def held(client: FibonacciClient) -> list[object]:
    """Return the open calls and the goals under way that a client holds."""
    requests = (client.goal_requests, client.result_requests, client.cancel_requests)
    calls = [call for each in requests for call in (*each.timed, *each.pending.values())]
    return [*(call for call in calls if not call.end_lock.locked()), *client.goals.active]


class Arm:
    """An action server, whose goals run until they are cancelled; it takes none before it is spun."""

    def __init__(self, node: Node) -> None:
        self.node = node
        self.running: Collector[Handle] = Collector()
        self.ended: Collector[str] = Collector()
        self._stop = threading.Event()
        self._is_cancelling = False
        self.server = ActionServer(
            node,
            Fibonacci,
            'fib',
            self._execute,
            cancel_callback=self._cancel,
            callback_group=ReentrantCallbackGroup(),
        )

    def _cancel(self, _: Handle) -> Any:
        from rclpy.action import CancelResponse

        self._is_cancelling = True
        self._stop.set()
        return CancelResponse.ACCEPT

    def _execute(self, handle: Handle) -> Fibonacci.Result:
        self.running(handle)
        assert self._stop.wait(PATIENCE)
        if self._is_cancelling:  # the goal is told after `_cancel` has returned, on another thread
            wait_for(lambda: handle.is_cancel_requested, 'the request to cancel')
        if handle.is_cancel_requested:
            handle.canceled()
            self.ended('cancelled')
        else:
            handle.succeed()
            self.ended('reached')
        return Fibonacci.Result()

    def stop(self) -> None:
        """Let what runs come to its end."""
        self._stop.set()


@pytest.fixture
def arm(make_node: MakeNode) -> Arm:
    """A server that nobody spins yet."""
    return Arm(make_node('arm'))


@pytest.fixture
def client(arm: Arm, make_node: MakeNode) -> FibonacciClient:
    """A client of it whose requests may take 50 ms."""
    client = ActionClient(make_node('hand'), Fibonacci, 'fib')
    assert client.wait_for_server(PATIENCE)
    client.call_timeout = 0.05
    return client


def test_a_goal_that_is_not_accepted_in_time_ends_so(client: FibonacciClient) -> None:
    future = client.send_goal_async(Goal())
    with pytest.raises(
        DeadlineError, match=r"^action '/fib' of node '/arm': no answer came in time; waited \d+\.\d{3} s$"
    ):
        client.send_goal(Goal())
    assert isinstance(error_of(future), DeadlineError)
    assert held(client) == []


def test_a_goal_that_is_accepted_too_late_is_cancelled(client: FibonacciClient, arm: Arm, spin: Spin) -> None:
    assert isinstance(error_of(client.send_goal_async(Goal())), DeadlineError)
    spin(arm.node, threads=4)
    assert arm.ended.expect(1) == ['cancelled']
    assert client.goals.active == {}
    assert client.goal_requests.late == {}


def test_nobody_waits_for_ever_for_a_late_acceptance(
    client: FibonacciClient, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(client_requests, 'LATE_S', 0.01)
    let_go: Collector[object] = Collector()
    port: Any = client.goal_requests._port
    cancel = port.cancel

    def told(sequence: int) -> None:
        cancel(sequence)
        let_go(sequence)

    monkeypatch.setattr(port, 'cancel', told)
    assert isinstance(error_of(client.send_goal_async(Goal())), DeadlineError)
    let_go.expect(1)
    assert client.goal_requests.late == {}


def test_only_the_latest_few_are_waited_for(client: FibonacciClient, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr('goalwire.entities.actions.client_requests.LATE_LIMIT', 2)
    for future in [client.send_goal_async(Goal()) for _ in range(5)]:
        assert isinstance(error_of(future), DeadlineError)
    assert len(client.goal_requests.late) == 2


def test_a_goal_waits_for_a_server_that_comes_in_time(make_node: MakeNode, spin: Spin) -> None:
    client = ActionClient(make_node(), Fibonacci, 'fib')
    client.call_timeout = PATIENCE
    early = client.send_goal_async(Goal())
    arm = Arm(make_node('arm'))
    arm.stop()
    spin(arm.node, threads=2)
    assert result_of(early).accepted
    assert arm.ended.expect(1) == ['reached']


def test_a_server_in_another_namespace_is_named(make_node: MakeNode) -> None:
    arm = Arm(make_node('arm', namespace='robot'))
    node = make_node('asker')
    client = ActionClient(node, Fibonacci, 'fib')
    client.call_timeout = 0.03
    wait_until(node.context, lambda: node.count_services('/robot/fib/_action/send_goal') == 1)
    with pytest.raises(NoServerError, match=r"did you mean '/robot/fib' of the node '/robot/arm'\?$"):
        client.send_goal(Goal())
    assert not client.wait_for_server(0.0)
    arm.stop()


def test_without_a_server_it_is_that_which_is_told(make_node: MakeNode) -> None:
    client = ActionClient(make_node(), Fibonacci, 'nosuch')
    client.call_timeout = 0.03
    with pytest.raises(
        NoServerError, match=r"^action '/nosuch': no server came in domain \d+ \(\w+\); waited \d+\.\d{3} s$"
    ) as told:
        client.send_goal(Goal())
    assert told.value.waited >= client.call_timeout
    assert held(client) == []


def test_a_goal_may_run_longer_than_calls_may_take(client: FibonacciClient, arm: Arm, spin: Spin) -> None:
    spin(arm.node, threads=4)
    client.call_timeout = PATIENCE
    handle = result_of(client.send_goal_async(Goal()))
    client.call_timeout = 0.01
    result = handle.get_result_async()
    arm.running.expect(1)
    assert not result.wait(STEADY.now() + 50_000_000)
    client.call_timeout = PATIENCE
    assert result_of(handle.cancel_goal_async()).goals_canceling
    assert result_of(result).status == GoalStatus.STATUS_CANCELED
    assert held(client) == []


def test_a_server_that_goes_before_it_answers_is_told_at_once(
    client: FibonacciClient, arm: Arm, context: Context
) -> None:
    client.call_timeout = PATIENCE
    sent = client.send_goal_async(Goal())
    arm.server.destroy()
    error = error_of(sent)
    assert isinstance(error, ServerLostError)
    assert (error.name, error.peers) == ('/fib', ('/arm',))
    wait_until(context, lambda: not client.server_is_ready())
    with pytest.raises(ServerLostError):
        client.cancel_all_goals()
    assert isinstance(error_of(client.get_result(bytes(16))), ServerLostError)
    assert held(client) == []


def test_giving_a_goal_up_leaves_nothing(client: FibonacciClient, make_node: MakeNode) -> None:
    client.call_timeout = PATIENCE
    waiting = ActionClient(make_node('other'), Fibonacci, 'nosuch')
    waiting.call_timeout = PATIENCE
    for each in (client, waiting):
        cancelled, lost = (each.send_goal_async(Goal()) for _ in range(2))
        assert len(each.goal_requests.timed) == 2
        cancelled.cancel()
        assert len(each.goal_requests.timed) == 1
        each.destroy()
        assert isinstance(error_of(lost), InvalidHandle)
        assert cancelled.cancelled()
        assert held(each) == []


def test_shutdown_ends_what_has_a_time(client: FibonacciClient, context: Context) -> None:
    client.call_timeout = PATIENCE
    future = client.send_goal_async(Goal())
    context.shutdown()
    assert isinstance(error_of(future), ShutDownError)


def test_a_client_has_so_many_goals_and_no_more(
    client: FibonacciClient, arm: Arm, spin: Spin, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr('goalwire.entities.actions.client.PENDING_LIMIT', 3)
    monkeypatch.setattr('goalwire.entities.actions.client_requests.PENDING_LIMIT', 3)
    client.call_timeout = PATIENCE
    sent = [client.send_goal_async(Goal()) for _ in range(3)]
    with pytest.raises(
        TooManyCallsError, match="cannot use the action '/fib': 3 requests of this client wait"
    ):
        _ = client.send_goal_async(Goal())
    spin(arm.node, threads=8)
    handles = [result_of(future) for future in sent]
    assert len(client.goals.active) == 3
    assert result_of(client.send_goal_async(Goal())).accepted  # nobody asks for the result of the oldest
    assert len(client.goals.active) == 3
    results = [handle.get_result_async() for handle in handles[1:]]
    last = result_of(client.send_goal_async(Goal()))
    results.append(last.get_result_async())
    with pytest.raises(TooManyCallsError, match="cannot send a goal to '/fib': 3 goals of this client are"):
        _ = client.send_goal_async(Goal())
    arm.stop()
    for result in results:
        assert result_of(result).status == GoalStatus.STATUS_SUCCEEDED
