"""rclpy.action.server: accepts goals, executes them, sends results."""

from __future__ import annotations

from collections.abc import Awaitable, Callable
from typing import TYPE_CHECKING, Generic, TypeAlias

from goalwire.entities.actions.advice import ActionAdvice
from goalwire.entities.actions.server import ActionServerCore
from goalwire.entities.actions.server_goal_handle import (
    ActionCallbacks,
    CancelResponse,
    GoalResponse,
    ServerGoalHandle,
)
from goalwire.entities.actions.server_settings import make_goal_server
from goalwire.entities.actions.types import ActionClass, FeedbackT, GoalT, ResultT
from goalwire.entities.type_support import action_support
from goalwire.errors import RCLError
from goalwire.execution.callback_arguments import advise_callback, describe_given, import_coroutine_runner
from goalwire.execution.callback_groups import check_group
from goalwire.execution.wait_sets.waitable import EventQueueWaitable
from goalwire.rules.goals.policy import UNLIMITED, GoalPolicy, OnClientLost
from goalwire.rules.goals.states import GoalEvent
from rclpy._reexports import reexport
from rclpy.action._making import action_qos, check_node, refusing_bad_names
from rclpy.callback_groups import CallbackGroup
from rclpy.constants import S_TO_NS
from rclpy.qos import QoSProfile, qos_profile_action_status_default, qos_profile_services_default
from rclpy.waitable import NumberOfEntities

if TYPE_CHECKING:
    from pathlib import Path

    from goalwire.execution.wait_sets.waitable import WaitSet
    from goalwire.logging import RcutilsLogger
    from goalwire.rules.goals.journal import GoalJournal
    from rclpy.impl.base_node import BaseNode

__all__ = [
    'ActionServer',
    'CancelResponse',
    'GoalEvent',
    'GoalResponse',
    'RCLError',
    'ServerGoalHandle',
    'default_cancel_callback',
    'default_goal_callback',
    'default_handle_accepted_callback',
]

_Handle: TypeAlias = ServerGoalHandle[GoalT, ResultT, FeedbackT]
_Decide: TypeAlias = Callable[[GoalT], GoalResponse | Awaitable[GoalResponse]]
_Accepted: TypeAlias = Callable[[ServerGoalHandle[GoalT, ResultT, FeedbackT]], object]
_Execute: TypeAlias = Callable[[ServerGoalHandle[GoalT, ResultT, FeedbackT]], ResultT | Awaitable[ResultT]]
_Cancel: TypeAlias = Callable[
    [ServerGoalHandle[GoalT, ResultT, FeedbackT]], CancelResponse | Awaitable[CancelResponse]
]
_Failed: TypeAlias = Callable[[ServerGoalHandle[GoalT, ResultT, FeedbackT], Exception], ResultT | None]

_FEEDBACK_QOS = QoSProfile(depth=10)


def default_handle_accepted_callback(goal_handle: ServerGoalHandle) -> None:
    """Execute the goal."""
    goal_handle.execute()


def default_goal_callback(goal_request: object) -> GoalResponse:
    """Accept every goal."""
    return GoalResponse.ACCEPT


def default_cancel_callback(cancel_request: object) -> CancelResponse:
    """Cancel no goal."""
    return CancelResponse.REJECT


class ActionServer(ActionServerCore, EventQueueWaitable, Generic[GoalT, ResultT, FeedbackT]):
    """Serves one action."""

    def __init__(
        self,
        node: BaseNode,
        action_type: ActionClass[GoalT, ResultT, FeedbackT],
        action_name: str,
        execute_callback: _Execute[GoalT, ResultT, FeedbackT] | None = None,
        *,
        callback_group: CallbackGroup | None = None,
        goal_callback: _Decide[GoalT] | None = default_goal_callback,
        handle_accepted_callback: _Accepted[GoalT, ResultT, FeedbackT]
        | None = default_handle_accepted_callback,
        cancel_callback: _Cancel[GoalT, ResultT, FeedbackT] | None = default_cancel_callback,
        goal_service_qos_profile: QoSProfile = qos_profile_services_default,
        result_service_qos_profile: QoSProfile = qos_profile_services_default,
        cancel_service_qos_profile: QoSProfile = qos_profile_services_default,
        feedback_pub_qos_profile: QoSProfile = _FEEDBACK_QOS,
        status_pub_qos_profile: QoSProfile = qos_profile_action_status_default,
        result_timeout: float = 10,
        policy: GoalPolicy = UNLIMITED,
        on_client_lost: OnClientLost = 'keep',
        on_failure: _Failed[GoalT, ResultT, FeedbackT] | None = None,
        client_grace: float = 0.0,
        journal: str | Path | GoalJournal | None = None,
    ) -> None:
        """Construct the server, which keeps results for `result_timeout` s; a negative time means for ever.

        For a callback that is None, the default is used. Without an execute callback the program calls
        `executing()` of an accepted goal's handle, and later `succeed(result)` or another method that ends
        the goal.

        The last five arguments are goalwire's own. `policy` limits the goals that run at a time.
        `on_client_lost` sets what happens to the goals of a client that has gone; first, other clients have
        `client_grace` s to ask for the goals' results. `on_failure` is called if an execute callback raises
        an error, and may return a result to send. With a `journal`, the path of a file, goal ids and results
        outlive the server: no goal id is executed twice, and results are kept as the journal says, whatever
        `result_timeout` is.

        Raises TypeError for an execute callback that is not callable or a timeout that is not a number,
        ValueError for a bad name or an unknown `on_client_lost`, JournalError, RCLError for a wrong
        parameter. A callback with wrong parameters gives a warning, and raises TypeError when it is called.
        """
        check_node(node, 'ActionServer')
        logger = node.get_logger()
        if execute_callback is not None:
            _check_callable(execute_callback, action_name, logger)
        decisions = goal_callback, handle_accepted_callback, cancel_callback
        _advise_decisions(decisions, action_name, logger)
        callbacks = ActionCallbacks(
            execute_callback,
            goal_callback or default_goal_callback,
            handle_accepted_callback or default_handle_accepted_callback,
            cancel_callback or default_cancel_callback,
            on_failure,
        )
        reactor = make_goal_server(
            node.handle,
            action_name,
            policy,
            on_client_lost,
            client_grace,
            journal,
            result_timeout_ns=_nanoseconds(result_timeout),
        )
        qos = action_qos(
            goal_service_qos_profile,
            result_service_qos_profile,
            cancel_service_qos_profile,
            feedback_pub_qos_profile,
            status_pub_qos_profile,
        )
        group = node.default_callback_group if callback_group is None else check_group(callback_group)
        support = action_support(action_type, action_name, call='ActionServer(node, {}, {}, execute)')
        EventQueueWaitable.__init__(self, group)
        self.advice = ActionAdvice(action_name, node.handle, default_cancel_callback)
        with refusing_bad_names('server', action_name):
            ActionServerCore.__init__(self, node.handle, support, action_name, callbacks, group, qos, reactor)
        self._node = node
        self._action_type = action_type
        node.add_waitable(self)
        node.handle.note_callback('action server')

    def get_num_entities(self) -> NumberOfEntities:
        """Return the numbers of this server's entities: three services, and a timer that expires results."""
        return NumberOfEntities(num_timers=1, num_services=3)

    def add_to_wait_set(self, wait_set: WaitSet) -> None:
        """Add the server's three services to `wait_set`."""
        for event_queue in self.event_queues():
            wait_set.add_service(event_queue)

    @property
    def _goal_handles(self) -> dict[bytes, object]:
        """The handles of the goals whose results are kept, by goal id; None for a goal that has ended.

        Programs read this private name of rclpy.
        """
        return {goal_id: goal.handle for goal_id, goal in self.reactor.goals.items()}

    @property
    def action_type(self) -> ActionClass[GoalT, ResultT, FeedbackT]:
        """The action class."""
        return self._action_type

    def register_handle_accepted_callback(
        self, handle_accepted_callback: _Accepted[GoalT, ResultT, FeedbackT] | None
    ) -> None:
        """Set the callback for accepted goals; None restores the default, which executes the goal at once."""
        self.callbacks.accepted = handle_accepted_callback or default_handle_accepted_callback

    def register_goal_callback(self, goal_callback: _Decide[GoalT] | None) -> None:
        """Set the goal callback; None restores the default, which accepts every goal."""
        self.callbacks.goal = goal_callback or default_goal_callback

    def register_cancel_callback(self, cancel_callback: _Cancel[GoalT, ResultT, FeedbackT] | None) -> None:
        """Set the cancel callback; None restores the default, which refuses every request."""
        self.callbacks.cancel = cancel_callback or default_cancel_callback

    def register_execute_callback(self, execute_callback: _Execute[GoalT, ResultT, FeedbackT]) -> None:
        """Set the execute callback; raises TypeError for an object that cannot be called."""
        _check_callable(execute_callback, self.name, self._node.get_logger())
        self.callbacks.execute = execute_callback

    def notify_execute(
        self,
        goal_handle: _Handle[GoalT, ResultT, FeedbackT],
        execute_callback: _Execute[GoalT, ResultT, FeedbackT] | None,
    ) -> None:
        """Start the execution of an accepted goal."""
        self.start_execution(goal_handle, execute_callback)

    def notify_goal_done(self) -> None:
        """Do nothing: at the end of a goal the server itself starts the expiry of its result."""

    def destroy(self) -> None:
        """Answer all open requests, abort running goals, and remove the server from the graph. Idempotent."""
        if not self.destroyed:
            self._node.remove_waitable(self)
        ActionServerCore.destroy(self)


def _nanoseconds(result_timeout: object) -> int:
    if not isinstance(result_timeout, int | float):
        raise TypeError(f'result_timeout is a number of seconds, got {result_timeout!r}')
    return int(result_timeout * S_TO_NS)


def _check_callable(execute_callback: object, action_name: str, logger: RcutilsLogger) -> None:
    if not callable(execute_callback):
        error = TypeError('Failed to register goal execution callback: not callable')
        error.add_note(describe_given(execute_callback))
        raise error
    what = f"the execute callback of the action '{action_name}'"
    advise_callback(execute_callback, ('goal_handle',), what, logger)
    import_coroutine_runner(execute_callback)


def _advise_decisions(
    decisions: tuple[Callable[..., object] | None, ...], action_name: str, logger: RcutilsLogger
) -> None:
    """Warn of callbacks with wrong parameters: those for a goal, an accepted goal, and a cancellation."""
    for callback, argument in zip(decisions, ('goal_request', 'goal_handle', 'goal_handle'), strict=True):
        if callback is not None:
            advise_callback(callback, (argument,), f"a callback of the action '{action_name}'", logger)


reexport(__name__)
