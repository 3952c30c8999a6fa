"""The five services of a managed node: through them a manager drives it, and tools show it."""

from __future__ import annotations

from collections.abc import Iterable
from typing import TYPE_CHECKING

from goalwire.entities.lifecycle.managed_node import LifecycleCore
from goalwire.entities.standard_types import standard_service
from goalwire.errors import RCLError, peer_text
from goalwire.logging import get_logger
from goalwire.rules.lifecycle import STATES, TRANSITIONS, Transition, TransitionCallbackReturnType
from goalwire.rules.qos import SERVICES_DEFAULT

if TYPE_CHECKING:
    from lifecycle_msgs.msg import TransitionDescription
    from lifecycle_msgs.srv import ChangeState, GetAvailableStates, GetAvailableTransitions, GetState

    from goalwire.execution.callback_groups import CallbackGroup


class LifecycleServices:
    """Answers for one managed node."""

    def __init__(self, core: LifecycleCore) -> None:
        self._core = core
        self._machine = core.machine
        self._logger = get_logger(core.node.logger_name)

    def offer(self, group: CallbackGroup | None) -> None:
        """Make the services, in ROS 2's order, in a callback group; None: in the node's default one."""
        node = self._core.node
        for service, type_name, answer in (
            ('change_state', 'ChangeState', self._change_state),
            ('get_state', 'GetState', self._get_state),
            ('get_available_states', 'GetAvailableStates', self._get_states),
            ('get_available_transitions', 'GetAvailableTransitions', self._get_transitions),
            ('get_transition_graph', 'GetAvailableTransitions', self._get_graph),
        ):
            support = standard_service(f'lifecycle_msgs/srv/{type_name}')
            node.make_service(support, f'{node.name.qualified}/{service}', answer, SERVICES_DEFAULT, group)

    def _change_state(
        self, request: ChangeState.Request, response: ChangeState.Response
    ) -> ChangeState.Response:
        """A label is stronger than an id, as in rclpy. What is not possible is answered, never raised."""
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
