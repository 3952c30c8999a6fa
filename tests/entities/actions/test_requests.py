"""The requests of an action client: goals, with however many servers, and results until they are there.

The wire gives a request for a result up long before a long goal has ended.
"""

from __future__ import annotations

import threading
from collections.abc import Callable, Iterator
from contextlib import ExitStack
from typing import Any

import pytest
from example_interfaces.action import Fibonacci
from helpers.collector import Collector
from helpers.cores import Front
from helpers.isolation import isolated_env
from helpers.patience import PATIENCE
from helpers.pending import left_pending
from helpers.spinning import Spinner, result_of

from goalwire.entities.actions.client import ActionClientCore
from goalwire.entities.actions.server import ActionServerCore
from goalwire.entities.actions.server_goal_handle import (
    ActionCallbacks,
    CancelResponse,
    GoalResponse,
    ServerGoalHandle,
)
from goalwire.entities.context import Context
from goalwire.entities.node import NodeCore
from goalwire.entities.type_support import action_support
from goalwire.errors import DeadlineError, ServerLostError, TransportError
from goalwire.execution.callback_groups import ReentrantCallbackGroup
from goalwire.execution.executors.multi_threaded import MultiThreadedExecutor
from goalwire.execution.future import Future
from goalwire.execution.time.steady_clock import STEADY
from goalwire.rules import reasons
from goalwire.rules.goals.ids import GoalId
from goalwire.rules.goals.states import GoalStatus
from goalwire.rules.goals.wire import encode_acceptance
from goalwire.transport.contract import Request, Sample
from goalwire.transport.zenoh import eclipse_wire

FIBONACCI = action_support(Fibonacci)
HELD_S = 0.15
"""How long Zenoh holds a request for a result here, instead of ten minutes."""


class Arm:
    """An action server whose goals run until `finish`; `asked` collects the requests for results."""

    def __init__(self, node: NodeCore, monkeypatch: pytest.MonkeyPatch) -> None:
        self.asked: Collector[int] = Collector()
        self._free = threading.Event()
        callbacks = ActionCallbacks(
            self._execute,
            goal=lambda _: GoalResponse.ACCEPT,
            accepted=ServerGoalHandle.execute,
            cancel=lambda _: CancelResponse.ACCEPT,
        )
        answer = ActionServerCore._on_result

        def on_result(server: ActionServerCore, request: Request, goal_id: GoalId) -> None:
            answer(server, request, goal_id)
            self.asked(request.sample.sequence)

        monkeypatch.setattr(ActionServerCore, '_on_result', on_result)
        self.node = node
        self.server = ActionServerCore(node, FIBONACCI, 'fib', callbacks, ReentrantCallbackGroup())

    def _execute(self, handle: ServerGoalHandle) -> Fibonacci.Result:
        assert self._free.wait(PATIENCE)
        handle.succeed()
        return Fibonacci.Result(sequence=[handle.request.order])

    def lose_results(self) -> None:
        """Go without an answer to those who wait for results."""
        _, results, _ = self.server._endpoints.servers
        results.destroy()

    def finish(self) -> None:
        """Let all goals end."""
        self._free.set()


@pytest.fixture
def make_node(monkeypatch: pytest.MonkeyPatch) -> Iterator[Callable[[str], NodeCore]]:
    """A function that makes a node on Zenoh, of a session and an executor of its own."""
    for name, value in isolated_env('rmw_zenoh_cpp').items():
        monkeypatch.setenv(name, value)
    with ExitStack() as stack:

        def make(name: str) -> NodeCore:
            context = Context()
            context.init(args=[])
            stack.callback(context.try_shutdown)
            node = NodeCore(context, name)
            executor = stack.enter_context(MultiThreadedExecutor(2, context=context))
            stack.enter_context(Spinner(executor, Front(node)))
            return node

        yield make


@pytest.fixture
def arm(make_node: Callable[[str], NodeCore], monkeypatch: pytest.MonkeyPatch) -> Iterator[Arm]:
    made = Arm(make_node('arm'), monkeypatch)
    yield made
    made.finish()


@pytest.fixture
def client(
    arm: Arm, make_node: Callable[[str], NodeCore], monkeypatch: pytest.MonkeyPatch
) -> ActionClientCore:
    """Its goals have a time of their own; its results have none, but typed errors."""
    monkeypatch.setattr(eclipse_wire, 'UNTIMED_S', HELD_S)
    monkeypatch.setenv('ZENOH_CONFIG_OVERRIDE', f'queries_default_timeout={int(HELD_S * 1000)}')
    made = ActionClientCore(make_node('hand'), FIBONACCI, 'fib', ReentrantCallbackGroup())
    made.call_timeout = PATIENCE
    return made


def awaited(client: ActionClientCore) -> Future[Any]:
    """Send a goal and return the future of its result."""
    return result_of(client.send(Fibonacci.Goal(order=3))).get_result_async()


def test_a_goal_that_outlives_its_request_brings_its_result_once(
    client: ActionClientCore, arm: Arm, capfd: pytest.CaptureFixture[str]
) -> None:
    result = awaited(client)
    done: Collector[Any] = Collector()
    result.add_done_callback(done)
    assert arm.asked.expect(4)[:4] == [1, 2, 3, 4]  # numbers of their own: servers refuse one that they know
    arm.finish()
    answer = result_of(result)
    assert (answer.status, list(answer.result.sequence)) == (GoalStatus.SUCCEEDED, [3])
    assert left_pending(client.node) == {}
    assert done.expect() == [result]
    assert client.statistics().goals.succeeded == 1
    assert capfd.readouterr().err == ''


def test_a_server_that_goes_later_is_told_at_once(client: ActionClientCore, arm: Arm) -> None:
    result = awaited(client)
    arm.asked.expect(2)
    arm.lose_results()
    assert result.wait(STEADY.now() + int(PATIENCE * 1e9))
    assert isinstance(result.exception(), ServerLostError)
    assert left_pending(client.node) == {}


def test_who_waits_no_longer_asks_no_more(client: ActionClientCore, arm: Arm) -> None:
    result = awaited(client)
    arm.asked.expect(2)
    result.cancel()
    assert [goal.request for goal in client.goals.ended.values()] == [None]
    assert left_pending(client.node) == {}


class Wire:
    """Stands in for the way to get_result: every request is kept."""

    def __init__(self) -> None:
        self.on_end: Collector[Callable[[str], None]] = Collector()
        self.forgotten: list[int] = []
        self.refuses = False

    def request(self, _: bytes, on_reply: object, on_end: Callable[[str], None], timeout_ns: object) -> int:
        assert (on_reply, timeout_ns) != (None, 0)
        if self.refuses:
            raise TransportError('the wire refuses')
        self.on_end(on_end)
        return len(self.on_end.items)

    def cancel(self, sequence: int) -> None:
        self.forgotten.append(sequence)


@pytest.fixture
def wired(spun: NodeCore, monkeypatch: pytest.MonkeyPatch) -> tuple[ActionClientCore, Wire]:
    made, wire = ActionClientCore(spun, FIBONACCI, 'fib', ReentrantCallbackGroup()), Wire()
    made.call_timeout = float('inf')
    monkeypatch.setattr(made.result_requests._port, 'request', wire.request)
    monkeypatch.setattr(made.result_requests._port, 'cancel', wire.cancel)
    return made, wire


GOAL_ID = bytes(range(16))


def test_all_who_wait_share_the_next_request_too(wired: tuple[ActionClientCore, Wire]) -> None:
    client, wire = wired
    waiting = [client.get_result(GOAL_ID) for _ in range(3)]
    wire.on_end.expect(1)[0](reasons.TIMEOUT)
    wire.on_end.expect(2)[1]('')
    for result in waiting:
        assert result.wait(STEADY.now() + int(PATIENCE * 1e9))
        assert isinstance(result.exception(), ServerLostError)
    assert len(wire.on_end.items) == 2


def test_a_result_that_is_wanted_again_has_one_request(wired: tuple[ActionClientCore, Wire]) -> None:
    client, wire = wired
    first = client.get_result(GOAL_ID)
    first.cancel()
    second = client.get_result(GOAL_ID)
    of_first, of_second = wire.on_end.expect(2)
    of_first(reasons.TIMEOUT)  # it is over
    of_second(reasons.TIMEOUT)
    wire.on_end.expect(3)
    assert second.pending()
    second.cancel()
    assert wire.forgotten == [1, 3]
    assert len(wire.on_end.items) == 3


def test_a_wire_that_refuses_to_ask_again_ends_the_wait(wired: tuple[ActionClientCore, Wire]) -> None:
    client, wire = wired
    result = client.get_result(GOAL_ID)
    wire.refuses = True
    wire.on_end.expect(1)[0](reasons.TIMEOUT)
    assert result.wait(STEADY.now() + int(PATIENCE * 1e9))
    assert isinstance(result.exception(), ServerLostError)
    assert [goal.request for goal in client.goals.ended.values()] == [None]


def test_a_server_that_gives_up_ends_the_wait(wired: tuple[ActionClientCore, Wire]) -> None:
    client, wire = wired
    result = client.get_result(GOAL_ID)
    wire.on_end.expect(1)[0](reasons.explain_failure(DeadlineError('mine')))
    assert result.exception() is not None
    assert len(wire.on_end.items) == 1


def test_another_servers_answer_is_told_though_the_first_came_before_the_request_had_its_number(
    spun: NodeCore, monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str]
) -> None:
    client = ActionClientCore(spun, FIBONACCI, 'fib', ReentrantCallbackGroup())
    answers: list[Callable[[Sample], None]] = []
    cancelled: list[int] = []
    accepted = Sample(encode_acceptance(accepted=True, stamp_ns=1), 1, 0, 0, bytes(16))

    def request(_: bytes, on_reply: Callable[[Sample], None], *_rest: object) -> int:
        answers.append(on_reply)
        on_reply(accepted)
        return 1

    monkeypatch.setattr(client.goal_requests._port, 'request', request)
    monkeypatch.setattr(client.goal_requests._port, 'cancel', cancelled.append)
    assert result_of(client.send(Fibonacci.Goal())).accepted
    assert cancelled == []
    assert client.goal_requests.pending == {}
    answers[0](accepted)
    assert 'Ignoring unexpected goal response' in capfd.readouterr().err
