"""A managed node: performs its transitions, and publishes an event for each.

Others ask for transitions through its five services.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable
from threading import Lock
from typing import TYPE_CHECKING

from goalwire.entities.endpoint import describe_endpoint
from goalwire.entities.lifecycle.managed_entity import ManagedEntity, call_each, check_outcome
from goalwire.entities.node import NodeCore
from goalwire.entities.standard_types import standard_message, standard_service
from goalwire.errors import ClosedError, GoalwireError, RCLError, peer_text
from goalwire.logging import get_logger
from goalwire.rules.lifecycle import (
    SHUTDOWN,
    STATES,
    TRANSITIONS,
    LifecycleMachine,
    LifecycleState,
    Transition,
    TransitionCallbackReturnType,
)
from goalwire.rules.qos import DEFAULT, SERVICES_DEFAULT
from goalwire.transport.contract import EndpointKind, PublisherPort

if TYPE_CHECKING:
    from lifecycle_msgs.msg import TransitionDescription
    from lifecycle_msgs.srv import ChangeState, GetAvailableStates, GetAvailableTransitions, GetState

    from goalwire.entities.service import ServiceCore
    from goalwire.execution.callback_groups import CallbackGroup


_NOT_REGISTERED = 'Failed to trigger lifecycle state machine transition: Transition is not registered.'


class LifecycleCore:
    """The lifecycle of one node, whose callbacks are those of `managed`; `now` gives its events' time in ns.

    Transitions may be asked for on any thread; one at a time is under way. No lock is held over callbacks.
    """

    def __init__(self, node: NodeCore, managed: ManagedEntity, now: Callable[[], int]) -> None:
        self.node = node
        self.entities: list[ManagedEntity] = []
        """Its managed entities, in the order in which they were added."""
        self.machine = LifecycleMachine()
        self._managed = managed
        self._events = TransitionEvents(node, now)
        self._lock = Lock()
        self._logger = get_logger(node.logger_name)

    def trigger(self, wanted: int | str) -> TransitionCallbackReturnType:
        """Make the transition of this id or label, and return its callback's answer.

        Raises RCLError if the present state has no such transition.
        """
        return self.perform(self.begin(wanted))

    def trigger_shutdown(self) -> TransitionCallbackReturnType:
        """Shut down from whichever state; raises RCLError during a transition, and once finalized."""
        state = self.machine.state
        if all(transition.label != SHUTDOWN for transition in self.machine.possible):
            raise RCLError(f"Shutdown transtion not possible: the node is '{state.label}'")
        return self.trigger(SHUTDOWN)

    def begin(self, wanted: int | str) -> Transition:
        """Start a transition that the caller then performs; raises RCLError if the present state has none."""
        with self._lock:
            state, possible = self.machine.state, self.machine.possible
            transition = self.machine.begin(wanted)
        if transition is None:
            get_logger('rcl_lifecycle').warning(
                f'No transition matching {wanted} found for current state {state.label}'
            )
            raise RCLError(f'{_NOT_REGISTERED} {_way_out(state, possible)}')
        return transition

    def perform(self, transition: Transition) -> TransitionCallbackReturnType:
        """Run the callbacks of a transition that has begun, to its end; return the first one's answer."""
        before = transition.start
        outcomes = []
        try:
            self._events.publish(transition)
            while transition.callback is not None:
                outcomes.append(self._outcome_of(transition.callback, before))
                transition = self.machine.end(outcomes[-1])
                self._events.publish(transition)
        finally:
            self._leave()
        return outcomes[0]

    def _outcome_of(self, callback: str, before: LifecycleState) -> TransitionCallbackReturnType:
        try:
            outcome = getattr(self._managed, callback)(before)
        except Exception as error:
            from goalwire.tracebacks import traceback_text

            told = f'Error raised in {callback}(): {peer_text(error)}'
            self._logger.error(f'{told}\n{traceback_text(error)}')
            return TransitionCallbackReturnType.ERROR
        try:
            return check_outcome(outcome, f'{callback}()')
        except TypeError as error:
            self._logger.error(str(error))
            return TransitionCallbackReturnType.ERROR

    def _leave(self) -> None:
        """Reach a primary state in any case: if a callback stops the program, the node is finalized."""
        while not self.machine.state.is_primary:
            self._events.publish(self.machine.end(TransitionCallbackReturnType.ERROR))

    def add(self, entity: ManagedEntity) -> None:
        """Add an entity that follows the transitions; raises TypeError for anything but a managed entity."""
        if not isinstance(entity, ManagedEntity):
            raise TypeError('Expected a rclpy.lifecycle.ManagedEntity instance.')
        if not self.manages(entity):
            self.entities.append(entity)

    def manages(self, entity: ManagedEntity) -> bool:
        """True for an entity that was added."""
        return any(known is entity for known in self.entities)

    def remove(self, entity: ManagedEntity) -> None:
        """Forget an entity; nothing happens if it was not added."""
        self.entities[:] = [known for known in self.entities if known is not entity]

    def call_entities(self, callback: str, state: LifecycleState) -> TransitionCallbackReturnType:
        """Call back the entities in turn, up to the first that does not say SUCCESS; raises TypeError."""
        return call_each(list(self.entities), callback, state)


class TransitionEvents:
    """Publishes every step on ~/transition_event."""

    def __init__(self, node: NodeCore, now: Callable[[], int]) -> None:
        self._now = now
        self._logger = get_logger(node.logger_name)
        self._support = standard_message('lifecycle_msgs/msg/TransitionEvent')
        name = node.resolve('~/transition_event')
        endpoint = describe_endpoint(node, EndpointKind.PUBLISHER, name, self._support, DEFAULT)
        self._port: PublisherPort = node.port.publisher(endpoint)
        node.own(self)

    def publish(self, transition: Transition) -> None:
        """Publish one step of a transition. Never raises: the transition counts, even without the wire."""
        from lifecycle_msgs.msg import State, TransitionEvent
        from lifecycle_msgs.msg import Transition as TransitionMessage

        event = TransitionEvent(
            timestamp=self._now(),
            transition=TransitionMessage(id=transition.id, label=transition.label),
            start_state=State(id=transition.start.state_id, label=transition.start.label),
            goal_state=State(id=transition.goal.state_id, label=transition.goal.label),
        )
        try:
            self._port.publish(self._support.encode(event))
        except ClosedError:
            pass  # a node that is destroyed, or shut down, goes through its transitions in silence
        except GoalwireError as error:
            self._logger.error(f'The {transition.label} event was not published: {error}')

    def destroy(self) -> None:
        """Undeclare the publisher. Idempotent."""
        self._port.close()


def _way_out(state: LifecycleState, possible: list[Transition]) -> str:
    if not state.is_primary:
        return f"A transition is under way ('{state.label}'): wait for its end"
    labels = ', '.join(f"'{transition.label}' ({transition.id})" for transition in possible)
    return f"From '{state.label}' there are: {labels or 'none'}"


class LifecycleServices:
    """The services of one managed node."""

    def __init__(self, core: LifecycleCore) -> None:
        self._core = core
        self._machine = core.machine
        self._logger = get_logger(core.node.logger_name)

    def offer(self, group: CallbackGroup | None) -> list[ServiceCore]:
        """Make the five services in a callback group (None: the node's default one); return them.

        Their order is ROS 2's: change_state, get_state, get_available_states, get_available_transitions,
        get_transition_graph.
        """
        node, services = self._core.node, []
        for service, type_name, answer in (
            ('change_state', 'ChangeState', self._change_state),
            ('get_state', 'GetState', self._get_state),
            ('get_available_states', 'GetAvailableStates', self._get_states),
            ('get_available_transitions', 'GetAvailableTransitions', self._get_transitions),
            ('get_transition_graph', 'GetAvailableTransitions', self._get_graph),
        ):
            support = standard_service(f'lifecycle_msgs/srv/{type_name}')
            name = f'{node.name.qualified}/{service}'
            services.append(node.make_service(support, name, answer, SERVICES_DEFAULT, group))
        return services

    def _change_state(
        self, request: ChangeState.Request, response: ChangeState.Response
    ) -> ChangeState.Response:
        """Answer a request for a transition. Its label wins over its id, as in rclpy. If the transition is
        not possible, the response says so: nothing is raised.
        """
        wanted = request.transition.label or request.transition.id
        try:
            transition = self._core.begin(wanted)
        except RCLError as error:
            self._logger.error(f'Unable to start transition {peer_text(wanted)}: {peer_text(error)}')
            response.success = False
            return response
        response.success = self._core.perform(transition) is TransitionCallbackReturnType.SUCCESS
        return response

    def _get_state(self, _: GetState.Request, response: GetState.Response) -> GetState.Response:
        state = self._machine.state
        response.current_state.id = state.state_id
        response.current_state.label = state.label
        return response

    def _get_states(
        self, _: GetAvailableStates.Request, response: GetAvailableStates.Response
    ) -> GetAvailableStates.Response:
        from lifecycle_msgs.msg import State

        response.available_states = [State(id=state.state_id, label=state.label) for state in STATES]
        return response

    def _get_transitions(
        self, _: GetAvailableTransitions.Request, response: GetAvailableTransitions.Response
    ) -> GetAvailableTransitions.Response:
        response.available_transitions = _descriptions(self._machine.possible)
        return response

    def _get_graph(
        self, _: GetAvailableTransitions.Request, response: GetAvailableTransitions.Response
    ) -> GetAvailableTransitions.Response:
        response.available_transitions = _descriptions(TRANSITIONS)
        return response


def _descriptions(transitions: Iterable[Transition]) -> list[TransitionDescription]:
    from lifecycle_msgs.msg import State, TransitionDescription
    from lifecycle_msgs.msg import Transition as TransitionMessage

    return [
        TransitionDescription(
            transition=TransitionMessage(id=transition.id, label=transition.label),
            start_state=State(id=transition.start.state_id, label=transition.start.label),
            goal_state=State(id=transition.goal.state_id, label=transition.goal.label),
        )
        for transition in transitions
    ]
