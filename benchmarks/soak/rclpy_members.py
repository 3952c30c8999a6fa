"""A server and a client as rclpy programs have them: callbacks, executors, threads that wait for futures."""

from __future__ import annotations

import threading
import time
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from functools import partial
from random import Random
from typing import Any, TypeVar

import rclpy
from action_msgs.msg import GoalStatus
from example_interfaces.action import Fibonacci
from example_interfaces.msg import Int64
from example_interfaces.srv import AddTwoInts
from rclpy.action import ActionClient, ActionServer, CancelResponse, GoalResponse
from rclpy.action.client import ClientGoalHandle
from rclpy.action.server import ServerGoalHandle
from rclpy.callback_groups import ReentrantCallbackGroup
from rclpy.executors import Executor, ExternalShutdownException, MultiThreadedExecutor, SingleThreadedExecutor
from rclpy.node import Node
from rclpy.task import Future

from benchmarks.soak.obedience import Obedience
from benchmarks.soak.report import Call, Report
from benchmarks.soak.work import (
    ABORT,
    DAWDLE,
    DAWDLE_S,
    FAIL,
    GIVEN_UP,
    MORTAL,
    REFUSE,
    STEADY,
    STEP_S,
    Work,
    choose,
)
from goalwire.errors import (
    DeadlineError,
    GoalAborted,
    GoalCanceled,
    GoalRefused,
    NoServerError,
    ServerFailedError,
)

T = TypeVar('T')


@contextmanager
def spinning(name: str, kind: type[Executor]) -> Iterator[Node]:
    """A node that a thread spins, in a context of its own."""
    context = rclpy.Context()
    rclpy.init(args=[], context=context)
    node = Node(name, context=context)
    executor = kind(context=context)
    executor.add_node(node)

    def spin() -> None:
        with suppress(ExternalShutdownException):
            executor.spin()

    thread = threading.Thread(target=spin)
    thread.start()
    try:
        yield node
    finally:
        rclpy.shutdown(context=context)
        thread.join()
        executor.shutdown()


# ---- the server ----


def serve(name: str, report: Report, stop: threading.Event) -> None:
    """Serve `<name>/add` and `<name>/count`, publish `<name>/tick`, until told to stop."""
    with spinning(f'{name}_server', MultiThreadedExecutor) as node:
        group = ReentrantCallbackGroup()
        node.create_service(AddTwoInts, f'{name}/add', partial(_add, report), callback_group=group)
        ActionServer(
            node,
            Fibonacci,
            f'{name}/count',
            partial(_count, report),
            goal_callback=lambda goal: GoalResponse.REJECT if goal.order == REFUSE else GoalResponse.ACCEPT,
            cancel_callback=lambda _: CancelResponse.ACCEPT,
            callback_group=group,
        )
        obedience = Obedience(report)
        node.create_subscription(Int64, f'{name}/move', lambda it: obedience.hear('message', it.data), 1000)
        node.create_service(AddTwoInts, f'{name}/step', partial(_step, obedience), callback_group=group)
        ActionServer(node, Fibonacci, f'{name}/walk', partial(_walk, obedience), callback_group=group)
        tick = node.create_publisher(Int64, f'{name}/tick', 10)
        node.create_timer(0.1, lambda: tick.publish(Int64(data=report.new_tag())))
        report.say('ready')
        stop.wait()


def _add(report: Report, request: AddTwoInts.Request, response: AddTwoInts.Response) -> AddTwoInts.Response:
    report.handled(request.a)
    if request.b in {DAWDLE, FAIL}:  # a callback that raises would end spin, as rclpy's does
        time.sleep(DAWDLE_S)
    response.sum = request.a + request.b
    return response


def _step(
    obedience: Obedience, request: AddTwoInts.Request, response: AddTwoInts.Response
) -> AddTwoInts.Response:
    obedience.hear('call', request.a)
    return response


def _walk(
    obedience: Obedience, handle: ServerGoalHandle[Fibonacci.Goal, Fibonacci.Result, Fibonacci.Feedback]
) -> Fibonacci.Result:
    obedience.hear('goal', handle.request.order)
    handle.succeed()
    return Fibonacci.Result()


def _count(
    report: Report, handle: ServerGoalHandle[Fibonacci.Goal, Fibonacci.Result, Fibonacci.Feedback]
) -> Fibonacci.Result:
    report.handled(bytes(handle.goal_id.uuid).hex())
    sequence: list[int] = []
    for step in range(handle.request.order):
        if handle.is_cancel_requested:
            handle.canceled()
            return Fibonacci.Result()
        sequence.append(step)
        handle.publish_feedback(Fibonacci.Feedback(sequence=sequence[-3:]))
        time.sleep(STEP_S)
    if handle.request.order == ABORT:
        handle.abort()
    else:
        handle.succeed()
    return Fibonacci.Result(sequence=sequence)


# ---- the client ----


def wait(future: Future[T], timeout: float) -> T:
    """Wait for a future that a spinning thread completes. Raises DeadlineError."""
    done = threading.Event()
    future.add_done_callback(lambda _: done.set())
    if not done.wait(timeout):
        raise DeadlineError('no answer came in time')
    result = future.result()
    if result is None:
        raise ServerFailedError('the future ended without an answer')
    return result


class Caller:
    """Calls all servers, one call at a time."""

    def __init__(self, node: Node, report: Report) -> None:
        self._report = report
        self._random = Random()
        servers = (*STEADY, *MORTAL)
        self._services = {
            name: node.create_client(AddTwoInts, f'{name}/add') for name in (*servers, 'nobody')
        }
        self._actions = {name: ActionClient(node, Fibonacci, f'{name}/count') for name in servers}

    def work(self, stop: threading.Event) -> None:
        while not stop.wait(self._random.uniform(0, 0.2)):
            work, server = choose(self._random)
            if work.ask == FAIL or work.outcome == GIVEN_UP:
                continue  # in rclpy's form such a call stays pending
            with self._report.call(work, server) as call:
                (self._goal if work.is_goal else self._call)(work, server, call)

    def _call(self, work: Work, server: str, call: Call) -> None:
        client = self._services[server]
        if not client.wait_for_service(work.timeout):
            raise NoServerError('no server came')
        future = client.call_async(AddTwoInts.Request(a=call.tag, b=work.ask))
        try:
            answer = wait(future, work.timeout)
        finally:
            client.remove_pending_request(future)
        self._report.check_sum(work, call, answer.sum)

    def _goal(self, work: Work, server: str, call: Call) -> None:
        client = self._actions[server]
        if not client.wait_for_server(work.timeout):
            raise NoServerError('no server came')
        seen: list[int] = []

        def on_feedback(message: Fibonacci.Impl.FeedbackMessage) -> None:
            seen.append(message.feedback.sequence[-1])

        handle = wait(client.send_goal_async(Fibonacci.Goal(order=work.ask), on_feedback), work.timeout)
        call.handled_as = bytes(handle.goal_id.uuid).hex()
        if not handle.accepted:
            raise GoalRefused('the server refused the goal')
        self._follow(work, handle, seen)

    def _follow(self, work: Work, handle: ClientGoalHandle[Any, Any, Any], seen: list[int]) -> None:
        ending = handle.get_result_async()
        try:
            if work.outcome == 'GoalCanceled':
                wait(handle.cancel_goal_async(), work.timeout)
            try:
                end = wait(ending, work.timeout)
            except DeadlineError:
                wait(handle.cancel_goal_async(), work.timeout)
                raise
        finally:
            ending.cancel()  # if the wait was given up: the client waits for nothing any more
            ending.exception()  # if it failed meanwhile: an error that nobody looks at is reported
        if end.status == GoalStatus.STATUS_ABORTED:
            raise GoalAborted('the goal was aborted')
        if end.status == GoalStatus.STATUS_CANCELED:
            raise GoalCanceled('the goal was cancelled')
        self._report.check_goal(work, end.result.sequence, list(seen))


def call(name: str, report: Report, stop: threading.Event, workers: int = 3) -> None:
    """Call all servers, until told to stop; then wait for what is under way."""
    with spinning(f'{name}_client', SingleThreadedExecutor) as node:
        caller = Caller(node, report)
        report.say('ready')
        threads = [threading.Thread(target=caller.work, args=(stop,)) for _ in range(workers)]
        for thread in threads:
            thread.start()
        for thread in threads:
            thread.join()
        report.check_empty(node.handle.statistics())
