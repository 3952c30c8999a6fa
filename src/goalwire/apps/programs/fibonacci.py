"""Servers and clients of /fibonacci: `examples_rclpy_minimal_action_*` and `action_tutorials_py`."""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence
from typing import Any

import rclpy
from action_msgs.msg import GoalStatus
from action_tutorials_interfaces.action import Fibonacci as TutorialFibonacci
from example_interfaces.action import Fibonacci
from rclpy.action import ActionClient, ActionServer, CancelResponse, GoalResponse
from rclpy.action.client import ClientGoalHandle
from rclpy.action.server import ServerGoalHandle
from rclpy.callback_groups import ReentrantCallbackGroup
from rclpy.executors import ExternalShutdownException, MultiThreadedExecutor
from rclpy.node import Node

ACTION = 'fibonacci'
ORDER = 10
PAUSE_S = 1.0
CANCEL_AFTER_S = 2.0


class FibonacciServer(Node):
    """Computes Fibonacci numbers up to index `order`, one a second, and sends each as feedback.

    `action` is one of the two types of this name, which differ in the name of the feedback field.
    """

    def __init__(self, name: str, action: type, field: str) -> None:
        super().__init__(name)
        self._action = action
        self._field = field
        self._server = ActionServer(
            self,
            action,
            ACTION,
            self._execute,
            callback_group=ReentrantCallbackGroup(),
            goal_callback=self._accept,
            cancel_callback=self._cancel,
        )

    def _accept(self, _goal: Any) -> GoalResponse:
        self.get_logger().info('Received goal request')
        return GoalResponse.ACCEPT

    def _cancel(self, _goal_handle: ServerGoalHandle) -> CancelResponse:
        self.get_logger().info('Received cancel request')
        return CancelResponse.ACCEPT

    def _execute(self, goal_handle: ServerGoalHandle) -> Any:
        self.get_logger().info('Executing goal...')
        sequence = [0, 1]
        feedback = self._action.Feedback()  # type: ignore[attr-defined]
        for _ in range(1, goal_handle.request.order):
            if goal_handle.is_cancel_requested:
                goal_handle.canceled()
                self.get_logger().info('Goal canceled')
                return self._action.Result()  # type: ignore[attr-defined]
            sequence.append(sequence[-1] + sequence[-2])
            setattr(feedback, self._field, sequence)
            self.get_logger().info(f'Publishing feedback: {sequence}')
            goal_handle.publish_feedback(feedback)
            time.sleep(PAUSE_S)
        goal_handle.succeed()
        result = self._action.Result(sequence=sequence)  # type: ignore[attr-defined]
        self.get_logger().info(f'Returning result: {sequence}')
        return result


class FibonacciClient(Node):
    """Sends one goal, logs its progress, and ends the program when the result comes."""

    def __init__(self, name: str, action: type, field: str, cancels: bool = False) -> None:
        super().__init__(name)
        self._action = action
        self._field = field
        self._cancels = cancels
        self._client = ActionClient(self, action, ACTION)
        self.result: Any = None

    def send(self, order: int = ORDER) -> None:
        """Wait for a server and send the goal."""
        self.get_logger().info('Waiting for action server...')
        self._client.wait_for_server()
        self.get_logger().info('Sending goal request...')
        goal = self._action.Goal(order=order)  # type: ignore[attr-defined]
        self._client.send_goal_async(goal, feedback_callback=self._hear).add_done_callback(self._take_answer)

    def _hear(self, message: Any) -> None:
        self.get_logger().info(f'Received feedback: {list(getattr(message.feedback, self._field))}')

    def _take_answer(self, future: Any) -> None:
        goal_handle: ClientGoalHandle = future.result()
        if not goal_handle.accepted:
            self.get_logger().info('Goal rejected :(')
            self.context.try_shutdown()
            return
        self.get_logger().info('Goal accepted :)')
        if self._cancels:
            timer = self.create_timer(CANCEL_AFTER_S, lambda: self._cancel(timer, goal_handle))
        else:
            goal_handle.get_result_async().add_done_callback(self._take_result)

    def _cancel(self, timer: Any, goal_handle: ClientGoalHandle) -> None:
        timer.cancel()
        self.get_logger().info('Canceling goal')
        goal_handle.cancel_goal_async().add_done_callback(self._take_cancel)

    def _take_cancel(self, future: Any) -> None:
        canceled = bool(future.result().goals_canceling)
        self.get_logger().info('Goal successfully canceled' if canceled else 'Goal failed to cancel')
        self.context.try_shutdown()

    def _take_result(self, future: Any) -> None:
        self.result = future.result().result
        if future.result().status == GoalStatus.STATUS_SUCCEEDED:
            self.get_logger().info(f'Goal succeeded! Result: {list(self.result.sequence)}')
        else:
            self.get_logger().info(f'Goal failed with status: {future.result().status}')
        self.context.try_shutdown()


def _serve(make_node: Callable[[], Node], args: Sequence[str] | None) -> int:
    """Spin on several threads, so that a cancel request is handled while a goal executes."""
    try:
        with rclpy.init(args=None if args is None else list(args)):
            executor = MultiThreadedExecutor()
            executor.add_node(make_node())
            executor.spin()
    except (KeyboardInterrupt, ExternalShutdownException):
        return 0
    return 0


def _ask(make_node: Callable[[], FibonacciClient], args: Sequence[str] | None) -> int:
    try:
        with rclpy.init(args=None if args is None else list(args)):
            node = make_node()
            node.send()
            rclpy.spin(node)
    except KeyboardInterrupt:
        return 130
    except ExternalShutdownException:
        return 0
    return 0


def serve(args: Sequence[str] | None = None) -> int:
    """Run the minimal action server."""
    return _serve(lambda: FibonacciServer('minimal_action_server', Fibonacci, 'sequence'), args)


def ask(args: Sequence[str] | None = None) -> int:
    """Run the minimal action client."""
    return _ask(lambda: FibonacciClient('minimal_action_client', Fibonacci, 'sequence'), args)


def ask_and_cancel(args: Sequence[str] | None = None) -> int:
    """Run the minimal action client that cancels its goal after 2 s."""
    return _ask(lambda: FibonacciClient('minimal_action_client', Fibonacci, 'sequence', cancels=True), args)


def serve_tutorial(args: Sequence[str] | None = None) -> int:
    """Run action_tutorials_py's server."""
    make = lambda: FibonacciServer('fibonacci_action_server', TutorialFibonacci, 'partial_sequence')  # noqa: E731
    return _serve(make, args)


def ask_tutorial(args: Sequence[str] | None = None) -> int:
    """Run action_tutorials_py's client."""
    make = lambda: FibonacciClient('fibonacci_action_client', TutorialFibonacci, 'partial_sequence')  # noqa: E731
    return _ask(make, args)
