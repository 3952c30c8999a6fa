"""Action servers: how a goal goes from its request to its result, whatever the callbacks do."""

from __future__ import annotations

import asyncio
import gc
import os
import sys
import threading
from collections.abc import Callable
from typing import Any

import pytest
from action_msgs.msg import GoalStatusArray
from builtin_interfaces.msg import Time
from example_interfaces.action import Fibonacci
from helpers.actions import (
    NAMES,
    Arena,
    Feedback,
    Gate,
    Goal,
    Result,
    accept_cancel,
    reject_goal,
    status_of,
    succeed,
)
from helpers.collector import Collector
from helpers.patience import PATIENCE
from helpers.spinning import MakeNode, Spin, result_of
from rclpy.action import ActionClient, ActionServer, CancelResponse, GoalResponse
from rclpy.action.server import ServerGoalHandle
from rclpy.executors import SingleThreadedExecutor

from goalwire.errors import RCLError

Handle = ServerGoalHandle


# -- a goal's way ----------------------------------------------------------------------------------------


@pytest.mark.parametrize('threads', [1, 4], ids=['single', 'multi'])
def test_accepted_executed_succeeded(make_node: MakeNode, spin: Spin, threads: int) -> None:
    trace: list[str] = []

    def execute(handle: Handle) -> Fibonacci.Result:
        trace.append(status_of(handle))
        for number in range(handle.request.order):
            handle.publish_feedback(Feedback(sequence=[number]))
        handle.succeed()
        trace.append(status_of(handle))
        return Result(sequence=[1, 2])

    arena = Arena(make_node, spin, execute, threads=threads)
    handle = arena.accept(2)
    assert arena.result(handle) == ('SUCCEEDED', [1, 2])
    assert arena.feedback.expect(2) == [[0], [1]]
    assert arena.seen(handle, 'SUCCEEDED') == ['EXECUTING', 'SUCCEEDED']
    assert trace == ['EXECUTING,act', 'SUCCEEDED,inact']
    assert NAMES[handle.status] == 'SUCCEEDED'


def test_a_refused_goal_is_never_executed_nor_shown(make_node: MakeNode, spin: Spin) -> None:
    arena = Arena(make_node, spin, lambda _: pytest.fail('executed'), goal=reject_goal)
    handle = arena.send()
    assert not handle.accepted
    assert handle.stamp == Time()
    assert arena.result(handle) == ('UNKNOWN', [])
    assert arena.statuses.items == []


def aborting(handle: Handle) -> Fibonacci.Result:
    handle.abort()
    return Result(sequence=[9])


def raising(handle: Handle) -> Fibonacci.Result:
    raise ValueError('in execute')


def raising_late(handle: Handle) -> Fibonacci.Result:
    handle.succeed()
    raise ValueError('in execute')


async def raising_later(handle: Handle) -> Fibonacci.Result:
    await asyncio.sleep(0)
    raise ValueError('in execute')


def stateless(handle: Handle) -> Fibonacci.Result:
    return Result(sequence=[5])


def nothing(handle: Handle) -> None:
    handle.succeed()


def number(handle: Handle) -> int:
    handle.succeed()
    return 5


def unsendable(handle: Handle) -> Fibonacci.Result:
    handle.succeed()
    result = Result()
    result.sequence = [2**31 - 1]
    return _with_bad_field(result)


def _with_bad_field(result: Fibonacci.Result) -> Fibonacci.Result:
    object.__setattr__(result, '_sequence', ['x'])
    return result


async def later(handle: Handle) -> Fibonacci.Result:
    await asyncio.sleep(0.01)
    handle.succeed()
    return Result(sequence=[7])


@pytest.mark.parametrize('threads', [1, 4], ids=['single', 'multi'])
@pytest.mark.parametrize(
    ('execute', 'status', 'sequence', 'logged'),
    [
        (aborting, 'ABORTED', [9], None),
        (raising, 'ABORTED', [], 'Error raised in execute callback: in execute'),
        (raising_late, 'SUCCEEDED', [], 'Error raised in execute callback: in execute'),
        (raising_later, 'ABORTED', [], 'Error raised in execute callback: in execute'),
        (stateless, 'ABORTED', [5], 'returned and did not say how the goal ended, so it counts as aborted'),
        (
            nothing,
            'SUCCEEDED',
            [],
            "returned NoneType; an empty result is sent; write 'return Fibonacci.Result(…)'",
        ),
        (
            number,
            'SUCCEEDED',
            [],
            "returned int; an empty result is sent; write 'return Fibonacci.Result(…)'",
        ),
        (unsendable, 'SUCCEEDED', [], 'Result cannot be sent, an empty one was sent: '),
        (later, 'SUCCEEDED', [7], None),
    ],
    ids=lambda value: getattr(value, '__name__', ''),
)
def test_how_execution_ends_the_goal(
    make_node: MakeNode,
    spin: Spin,
    capfd: pytest.CaptureFixture[str],
    execute: Callable[[Handle], Any],
    status: str,
    sequence: list[int],
    logged: str | None,
    threads: int,
) -> None:
    arena = Arena(make_node, spin, execute, threads=threads)
    handle = arena.accept()
    assert arena.result(handle) == (status, sequence)
    assert arena.seen(handle, status) == ['EXECUTING', status]
    printed = capfd.readouterr().err
    if logged is None:
        assert printed == ''
    else:
        assert '[server.action_server]: ' in printed
        assert logged in printed
    if execute in {raising, raising_late, raising_later}:
        assert 'Traceback' in printed
        assert f'in {execute.__name__}' in printed


def test_a_handle_refuses_what_its_state_does_not_allow(make_node: MakeNode, spin: Spin) -> None:
    refused: list[str] = []

    def attempt(action: Callable[[], object]) -> None:
        with pytest.raises(RCLError, match='goal_handle attempted invalid transition') as caught:
            action()
        refused.append(str(caught.value).partition('from state ')[2])

    def execute(handle: Handle) -> Fibonacci.Result:
        attempt(handle.execute)
        attempt(handle.canceled)
        handle.succeed()
        for action in (handle.succeed, handle.abort, handle.canceled):
            attempt(action)
        return Result(sequence=[1])

    arena = Arena(make_node, spin, execute)
    assert arena.result(arena.accept()) == ('SUCCEEDED', [1])
    assert refused == [
        'EXECUTING with event EXECUTE',
        'EXECUTING with event CANCELED',
        'SUCCEEDED with event SUCCEED',
        'SUCCEEDED with event ABORT',
        'SUCCEEDED with event CANCELED',
    ]


@pytest.mark.parametrize('wrong', [1, None, Result()], ids=repr)
def test_only_feedback_of_the_action_is_published(make_node: MakeNode, spin: Spin, wrong: Any) -> None:
    def execute(handle: Handle) -> Fibonacci.Result:
        with pytest.raises(TypeError, match=r'^expected .*Fibonacci\.Feedback'):
            handle.publish_feedback(wrong)
        handle.succeed()
        return Result()

    arena = Arena(make_node, spin, execute)
    assert arena.result(arena.accept())[0] == 'SUCCEEDED'


def test_a_handle_may_outlive_its_goal(make_node: MakeNode, spin: Spin) -> None:
    gate = Gate()
    gate.open()

    def execute(handle: Handle) -> Fibonacci.Result:
        gate(handle)
        return succeed(handle)

    arena = Arena(make_node, spin, execute, result_timeout=0)
    arena.result(arena.accept())
    (kept,) = gate.reached.items
    assert (kept.status, kept.is_active, kept.is_cancel_requested) == (0, False, False)
    kept.succeed()
    kept.abort()
    kept.publish_feedback(Feedback())


# -- what the goal callback answers ----------------------------------------------------------------------


@pytest.mark.parametrize('answer', [None, True, 'yes'], ids=repr)
def test_an_answer_that_is_no_goal_response_refuses(
    make_node: MakeNode, spin: Spin, capfd: pytest.CaptureFixture[str], answer: object
) -> None:
    arena = Arena(make_node, spin, succeed, goal=lambda _: answer)
    assert not arena.send().accepted
    text = 'so the goal is refused: return GoalResponse.ACCEPT or GoalResponse.REJECT'
    assert text in capfd.readouterr().err


@pytest.mark.parametrize('threads', [1, 4], ids=['single', 'multi'])
@pytest.mark.parametrize('coroutine', [False, True], ids=['plain', 'coroutine'])
def test_a_goal_callback_that_raises_refuses_and_the_error_comes_out_of_spin(
    make_node: MakeNode, spin: Spin, coroutine: bool, threads: int
) -> None:
    def raise_(goal: object) -> GoalResponse:
        raise ZeroDivisionError

    async def raise_later(goal: object) -> GoalResponse:
        await asyncio.sleep(0)
        raise ZeroDivisionError

    arena = Arena(make_node, spin, succeed, goal=raise_later if coroutine else raise_, threads=threads)
    assert not arena.send().accepted
    arena.spinner.expect_raised(ZeroDivisionError)
    arena.server.register_goal_callback(None)
    assert arena.result(arena.accept(3)) == ('SUCCEEDED', [3])


def test_every_callback_may_be_a_coroutine(make_node: MakeNode, spin: Spin) -> None:
    trace: Collector[str] = Collector()

    async def goal(request: Any) -> GoalResponse:
        await asyncio.sleep(0.01)
        trace(f'goal {request.order}')
        return GoalResponse.ACCEPT

    async def accepted(handle: Handle) -> None:
        await asyncio.sleep(0.01)
        trace('accepted')
        handle.execute()

    async def cancel(handle: Handle) -> CancelResponse:
        await asyncio.sleep(0.01)
        trace('cancel')
        return CancelResponse.ACCEPT

    async def execute(handle: Handle) -> Fibonacci.Result:
        trace('execute')
        while not handle.is_cancel_requested:  # noqa: ASYNC110 - as programs for rclpy do
            await asyncio.sleep(0.005)
        handle.canceled()
        return Result(sequence=[1])

    arena = Arena(make_node, spin, execute, goal=goal, accepted=accepted, cancel=cancel, threads=1)
    handle = arena.accept(7)
    trace.expect(3)
    assert arena.cancel(handle.goal_id) == (0, [bytes(handle.goal_id.uuid)])
    assert arena.result(handle) == ('CANCELED', [1])
    assert trace.items == ['goal 7', 'accepted', 'execute', 'cancel']


@pytest.mark.parametrize('threads', [1, 4], ids=['single', 'multi'])
def test_async_goals_run_beside_each_other(make_node: MakeNode, spin: Spin, threads: int) -> None:
    running: Collector[int] = Collector()

    async def execute(handle: Handle) -> Fibonacci.Result:
        running(handle.request.order)
        while len(running.items) < 20:  # noqa: ASYNC110
            await asyncio.sleep(0.001)
        return succeed(handle)

    arena = Arena(make_node, spin, execute, threads=threads)
    handles = [arena.accept(order) for order in range(20)]
    assert [arena.result(handle) for handle in handles] == [('SUCCEEDED', [order]) for order in range(20)]


def test_a_second_goal_waits_under_the_single_threaded_executor(make_node: MakeNode, spin: Spin) -> None:
    trace: list[str] = []

    def execute(handle: Handle) -> Fibonacci.Result:
        trace.append(f'start {handle.request.order}')
        trace.append(f'end {handle.request.order}')
        return succeed(handle)

    arena = Arena(make_node, spin, execute, threads=1)
    futures = [arena.client.send_goal_async(Goal(order=order)) for order in (1, 2)]
    for order, future in enumerate(futures, 1):
        assert arena.result(result_of(future)) == ('SUCCEEDED', [order])
    assert trace == ['start 1', 'end 1', 'start 2', 'end 2']


def test_blocking_goals_run_beside_each_other_under_the_multi_threaded_executor(
    make_node: MakeNode, spin: Spin
) -> None:
    together = threading.Barrier(3, timeout=PATIENCE)

    def execute(handle: Handle) -> Fibonacci.Result:
        together.wait(PATIENCE)
        return succeed(handle)

    arena = Arena(make_node, spin, execute, threads=5)
    handles = [arena.accept(order) for order in range(3)]
    assert [arena.result(handle)[1] for handle in handles] == [[0], [1], [2]]


# -- deferred execution ----------------------------------------------------------------------------------


def test_a_kept_goal_waits_for_execute(make_node: MakeNode, spin: Spin) -> None:
    kept: Collector[Handle] = Collector()
    arena = Arena(make_node, spin, succeed, accepted=kept)
    handle = arena.accept(4)
    (goal,) = kept.expect()
    assert status_of(goal) == 'ACCEPTED,act'
    result = handle.get_result_async()
    assert arena.cancel(handle.goal_id) == (0, [])
    assert not result.done()
    for action in (goal.succeed, goal.abort, goal.canceled):
        with pytest.raises(RCLError, match='from state ACCEPTED'):
            action()
    goal.execute()
    assert NAMES[result_of(result).status] == 'SUCCEEDED'
    with pytest.raises(RCLError, match='from state SUCCEEDED with event EXECUTE'):
        goal.execute()


def test_a_kept_goal_may_be_executed_by_another_callback(make_node: MakeNode, spin: Spin) -> None:
    def other(handle: Handle) -> Fibonacci.Result:
        handle.succeed()
        return Result(sequence=[99])

    arena = Arena(make_node, spin, succeed, accepted=lambda handle: handle.execute(other))
    assert arena.result(arena.accept()) == ('SUCCEEDED', [99])


def test_a_goal_cancelled_before_its_execution_is_seen_canceling(make_node: MakeNode, spin: Spin) -> None:
    kept: Collector[Handle] = Collector()
    seen: list[str] = []

    def execute(handle: Handle) -> Fibonacci.Result:
        seen.append(status_of(handle))
        handle.canceled()
        return Result(sequence=[3])

    arena = Arena(make_node, spin, execute, accepted=kept, cancel=accept_cancel)
    handle = arena.accept()
    (goal,) = kept.expect()
    assert arena.cancel(handle.goal_id)[0] == 0
    assert status_of(goal) == 'CANCELING,act,creq'
    goal.execute()
    assert arena.result(handle) == ('CANCELED', [3])
    assert seen == ['CANCELING,act,creq']


def test_a_goal_cancelled_before_its_execution_may_end_without(make_node: MakeNode, spin: Spin) -> None:
    """rclpy never answers the request for the result."""
    kept: Collector[Handle] = Collector()
    arena = Arena(make_node, spin, succeed, accepted=kept, cancel=accept_cancel)
    handle = arena.accept()
    (goal,) = kept.expect()
    arena.cancel(handle.goal_id)
    goal.canceled()
    assert arena.result(handle) == ('CANCELED', [])
    assert [goal.handle for goal in arena.server.reactor.goals.values()] == [None]


def test_no_callback_means_the_default_one(make_node: MakeNode, spin: Spin) -> None:
    server, node = make_node('server'), make_node()
    ActionServer(
        server, Fibonacci, 'fib', succeed,
        goal_callback=None, handle_accepted_callback=None, cancel_callback=None,
    )  # fmt: skip
    client = ActionClient(node, Fibonacci, 'fib')
    assert client.wait_for_server(PATIENCE)
    spin(server)
    handle = result_of(client.send_goal_async(Goal(order=4)))
    assert handle.accepted
    assert list(result_of(handle.get_result_async()).result.sequence) == [4]


def test_an_accepted_callback_that_raises_comes_out_of_spin(make_node: MakeNode, spin: Spin) -> None:
    def accepted(handle: Handle) -> None:
        raise ZeroDivisionError

    arena = Arena(make_node, spin, succeed, accepted=accepted)
    assert arena.send().accepted
    arena.spinner.expect_raised(ZeroDivisionError)


# -- the end of a server ---------------------------------------------------------------------------------


def test_a_server_destroyed_while_goals_run_answers_everybody(make_node: MakeNode, spin: Spin) -> None:
    gate = Gate()
    after: Collector[str] = Collector()

    def execute(handle: Handle) -> Fibonacci.Result:
        gate(handle)
        handle.publish_feedback  # noqa: B018 - a handle stays usable
        handle.succeed()
        after(status_of(handle))
        return Result(sequence=[1])

    arena = Arena(make_node, spin, execute)
    handle = arena.accept()
    result = handle.get_result_async()
    gate.reached.expect()
    arena.expect_event('on_result_request')
    arena.server.destroy()
    arena.server.destroy()
    assert NAMES[result_of(result).status] == 'ABORTED'
    gate.open()
    assert after.expect() == ['UNKNOWN,inact']
    assert arena.seen(handle, 'ABORTED')[-1] == 'ABORTED'
    assert list(arena.server_node.waitables) == []


def test_the_end_of_the_context_ends_what_runs_without_complaint(
    make_node: MakeNode, spin: Spin, capfd: pytest.CaptureFixture[str]
) -> None:
    gate, over = Gate(), threading.Event()

    def execute(handle: Handle) -> Fibonacci.Result:
        gate(handle)
        handle.succeed()
        over.set()
        return Result(sequence=[1])

    arena = Arena(make_node, spin, execute)
    arena.accept()
    gate.reached.expect()
    arena.server_node.context.shutdown()
    gate.open()
    assert over.wait(PATIENCE)
    arena.spinner.close()
    assert capfd.readouterr().err == ''


# -- arguments -------------------------------------------------------------------------------------------


def test_wrong_arguments_are_refused_with_rclpys_exceptions(make_node: MakeNode) -> None:
    node = make_node()
    text = 'Failed to register goal execution callback: not callable'
    for wrong in (5, 'text'):
        with pytest.raises(TypeError, match=text):
            ActionServer(node, Fibonacci, 'fib', wrong)  # type: ignore[arg-type]
    with pytest.raises(ValueError, match=r"Failed to create action server.*'a b'"):
        ActionServer(node, Fibonacci, 'a b', succeed)
    with pytest.raises(ValueError, match='Failed to create action server'):
        ActionServer(node, Fibonacci, '', succeed)
    with pytest.raises(AttributeError, match='a class of a message, a service or an action is needed'):
        ActionServer(node, int, 'fib', succeed)  # type: ignore[arg-type]
    with pytest.raises(RuntimeError, match='action type provided is not valid'):
        ActionServer(node, GoalStatusArray, 'fib', succeed)  # type: ignore[arg-type]
    with pytest.raises(TypeError, match='result_timeout'):
        ActionServer(node, Fibonacci, 'fib', succeed, result_timeout='x')  # type: ignore[arg-type]
    assert list(node.waitables) == []
    with ActionServer(node, Fibonacci, 'fib', succeed) as server:
        assert server.action_type is Fibonacci
        with pytest.raises(TypeError, match=text):
            server.register_execute_callback(None)  # type: ignore[arg-type]
    assert server.destroyed


def test_a_goal_may_outlive_its_server_and_its_node(make_node: MakeNode, spin: Spin) -> None:
    kept: Collector[Handle] = Collector()
    arena = Arena(make_node, spin, succeed, accepted=kept)
    arena.accept()
    (goal,) = kept.expect()
    arena.server_node.destroy_node()
    goal.publish_feedback(Fibonacci.Feedback())
    goal.succeed()
    arena.server.destroy()
    goal.publish_feedback(Fibonacci.Feedback())
    with pytest.raises(TypeError):
        goal.publish_feedback('text')


@pytest.mark.slow
@pytest.mark.timeout(400)
def test_memory_is_flat_after_many_goals(monkeypatch: pytest.MonkeyPatch) -> None:
    from helpers.isolation import isolated_env
    from rclpy.context import Context
    from rclpy.node import Node

    batches = int(os.environ.get('GOALWIRE_TEST_GOALS', '5000')) // 1000
    for name, value in isolated_env('goalwire_memory').items():
        monkeypatch.setenv(name, value)
    context = Context()
    context.init(args=[])
    node = Node('both', context=context)
    server = ActionServer(node, Fibonacci, 'fib', succeed, result_timeout=0)
    client = ActionClient(node, Fibonacci, 'fib')
    with SingleThreadedExecutor(context=context) as executor:
        executor.add_node(node)

        def batch(number: int) -> None:
            sent = [client.send_goal_async(Goal(order=order)) for order in range(number)]
            for order, future in enumerate(sent):
                executor.spin_until_future_complete(future, PATIENCE)
                handle = future.result()
                assert handle is not None
                result = handle.get_result_async()
                executor.spin_until_future_complete(result, PATIENCE)
                response: Any = result.result()
                assert response.status in {0, 4}  # 0: it was over, and not kept
                assert response.status == 0 or list(response.result.sequence) == [order]
            executor.spin_once(0)

        try:
            batch(1000)
            gc.collect()
            before = sys.getallocatedblocks()
            for _ in range(batches):
                batch(1000)
            gc.collect()
            grown = sys.getallocatedblocks() - before
            assert server.reactor.statistics().retained == 0
        finally:
            context.shutdown()
    assert grown < 100 * batches  # a tenth of one object a goal
