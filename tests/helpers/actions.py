"""A server and a client of one action in two nodes, with everything that happened written down."""

from __future__ import annotations

import threading
from collections.abc import Callable
from typing import Any

from action_msgs.msg import GoalInfo, GoalStatusArray
from action_msgs.srv import CancelGoal
from builtin_interfaces.msg import Time
from example_interfaces.action import Fibonacci
from helpers.collector import Collector
from helpers.patience import PATIENCE
from helpers.spinning import MakeNode, Spinner, result_of, wait_until
from rclpy.action import ActionClient, ActionServer, CancelResponse, GoalResponse
from rclpy.action.client import ClientGoalHandle
from rclpy.action.server import ServerGoalHandle
from rclpy.callback_groups import ReentrantCallbackGroup
from rclpy.qos import DurabilityPolicy, QoSProfile
from unique_identifier_msgs.msg import UUID

NAMES = ['UNKNOWN', 'ACCEPTED', 'EXECUTING', 'CANCELING', 'SUCCEEDED', 'CANCELED', 'ABORTED']
"""The statuses by number (action_msgs/msg/GoalStatus)."""
Goal, Result, Feedback = Fibonacci.Goal, Fibonacci.Result, Fibonacci.Feedback
NO_ID = UUID()
_ALL = QoSProfile(depth=1000, durability=DurabilityPolicy.TRANSIENT_LOCAL)


def status_of(handle: ServerGoalHandle) -> str:
    """Return what a server's handle says: the status, and whether a cancellation is asked for."""
    asked = ',creq' if handle.is_cancel_requested else ''
    return f'{NAMES[handle.status]},{"act" if handle.is_active else "inact"}{asked}'


def id_of(handle: ClientGoalHandle) -> bytes:
    """Return a goal's id, 16 bytes."""
    return bytes(handle.goal_id.uuid)


class Arena:
    """A server with a script, a client, and a plain subscriber of the status topic.

    `execute` is what the server runs. `spinner` spins the server's node, the client's stands in the same
    executor; `observer` hears the statuses through an executor of its own.
    """

    def __init__(
        self,
        make_node: MakeNode,
        spin: Callable[..., Spinner],
        execute: Callable[[ServerGoalHandle], Any],
        *,
        threads: int = 4,
        goal: Callable[..., Any] | None = None,
        cancel: Callable[..., Any] | None = None,
        accepted: Callable[..., Any] | None = None,
        **options: Any,
    ) -> None:
        self.server_node = make_node('server')
        self.client_node = make_node('client')
        self.observer = make_node('observer')
        given = {'goal_callback': goal, 'cancel_callback': cancel, 'handle_accepted_callback': accepted}
        options |= {name: callback for name, callback in given.items() if callback is not None}
        options.setdefault('callback_group', ReentrantCallbackGroup())
        self.server = ActionServer(self.server_node, Fibonacci, 'fib', execute, **options)
        self.events: Collector[str] = Collector()
        """The events that the server's reactor has been told, by its methods' names."""
        self._note_events()
        self.client = ActionClient(
            self.client_node, Fibonacci, 'fib', callback_group=ReentrantCallbackGroup()
        )
        self.cancel_client = self.client_node.create_client(CancelGoal, 'fib/_action/cancel_goal')
        self.feedback: Collector[list[int]] = Collector()
        self.statuses: Collector[GoalStatusArray] = Collector()
        self.observer.create_subscription(GoalStatusArray, 'fib/_action/status', self.statuses, _ALL)
        context = self.server_node.context
        assert self.client.wait_for_server(PATIENCE)
        assert self.cancel_client.wait_for_service(PATIENCE)
        wait_until(context, lambda: self.observer.count_publishers('fib/_action/status') == 1)
        wait_until(context, lambda: self.observer.count_subscribers('fib/_action/feedback') == 1)
        self.spinner = spin(self.server_node, self.client_node, threads=threads)
        spin(self.observer)

    def _note_events(self) -> None:
        dispatch = self.server.dispatch

        def note(event: Callable[..., Any], *args: Any) -> Any:
            effects = dispatch(event, *args)
            self.events(event.__name__)
            return effects

        self.server.dispatch = note  # type: ignore[method-assign]

    def expect_event(self, name: str) -> None:
        """Wait until the server's reactor has been told of such an event."""
        self.events.wait_for(lambda names: name in names)

    def hear(self, message: Fibonacci.Impl.FeedbackMessage) -> None:
        """Note feedback, as the client's feedback callback."""
        self.feedback(list(message.feedback.sequence))

    def send(self, order: int = 1, goal_uuid: UUID | None = None) -> ClientGoalHandle:
        """Send a goal and wait for the answer."""
        return result_of(self.client.send_goal_async(Goal(order=order), self.hear, goal_uuid))

    def accept(self, order: int = 1, goal_uuid: UUID | None = None) -> ClientGoalHandle:
        """Send a goal that must be accepted."""
        handle = self.send(order, goal_uuid)
        assert handle.accepted
        return handle

    @staticmethod
    def result(handle: ClientGoalHandle) -> tuple[str, list[int]]:
        """Wait for a goal's end; return status and sequence."""
        response = result_of(handle.get_result_async())
        return NAMES[response.status], list(response.result.sequence)

    def cancel(self, goal_id: UUID = NO_ID, stamp: Time | None = None) -> tuple[int, list[bytes]]:
        """Send a raw cancel request; return code and ids of the goals that are cancelling."""
        info = GoalInfo(goal_id=goal_id, stamp=stamp or Time())
        response = result_of(self.cancel_client.call_async(CancelGoal.Request(goal_info=info)))
        return response.return_code, [bytes(goal.goal_id.uuid) for goal in response.goals_canceling]

    def seen(self, handle: ClientGoalHandle, last: str) -> list[str]:
        """Wait until the status topic shows a goal as `last`; return its different statuses so far."""
        self.statuses.wait_for(lambda arrays: self._history(arrays, handle)[-1:] == [last])
        return self._history(self.statuses.items, handle)

    @staticmethod
    def _history(arrays: list[GoalStatusArray], handle: ClientGoalHandle) -> list[str]:
        history: list[str] = []
        for array in arrays:
            for entry in array.status_list:
                if bytes(entry.goal_info.goal_id.uuid) == bytes(handle.goal_id.uuid):
                    name = NAMES[entry.status]
                    if history[-1:] != [name]:
                        history.append(name)
        return history


class Gate:
    """Where an execute callback waits until the test lets it go on, or its goal is to be cancelled."""

    def __init__(self) -> None:
        self.reached: Collector[ServerGoalHandle] = Collector()
        self._open = threading.Event()

    def open(self) -> None:
        """Let everybody pass."""
        self._open.set()

    def __call__(self, handle: ServerGoalHandle) -> None:
        """Wait at the gate."""
        self.reached(handle)
        assert self._open.wait(PATIENCE)


class Patient:
    """Executes goals that wait at the gate; each ends as it was asked to by then. Its result is the order."""

    def __init__(self) -> None:
        self.gate = Gate()

    def __call__(self, handle: ServerGoalHandle) -> Fibonacci.Result:
        self.gate(handle)
        if handle.is_cancel_requested:
            handle.canceled()
        elif handle.is_active:
            handle.succeed()
        return Result(sequence=[handle.request.order])

    def wait_for(self, *orders: int) -> None:
        """Wait until exactly these goals have come to the gate, in this order."""
        self.gate.reached.wait_for(lambda seen: [each.request.order for each in seen] == list(orders))


def succeed(handle: ServerGoalHandle) -> Fibonacci.Result:
    """Execute a goal at once; its result is the order."""
    handle.succeed()
    return Result(sequence=[handle.request.order])


def accept_cancel(_: object) -> CancelResponse:
    """Let every goal be cancelled."""
    return CancelResponse.ACCEPT


def reject_goal(_: object) -> GoalResponse:
    """Refuse every goal."""
    return GoalResponse.REJECT
