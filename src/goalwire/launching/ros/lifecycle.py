"""Managed nodes in a launch: events for their transitions, and actions that request transitions.

The launch's own node subscribes to each managed node's ~/transition_event and calls its ~/change_state.
"""

from __future__ import annotations

import asyncio
from collections.abc import Callable, Iterable
from functools import partial
from typing import Any

from goalwire.errors import BadLaunchValueError, CallError, LaunchError
from goalwire.launching.actions import EmitEvent, OpaqueFunction, RegisterEventHandler
from goalwire.launching.events import Shutdown
from goalwire.launching.exposure import expose_action
from goalwire.launching.frontend import Entity, Parser
from goalwire.launching.model import (
    Action,
    Event,
    EventHandler,
    LaunchContext,
    SomeEntities,
    SomeSubstitutions,
)
from goalwire.launching.output import get_logger
from goalwire.launching.ros.node import Node
from goalwire.launching.ros.own_node import LaunchNode
from goalwire.launching.values import normalize_to_list_of_substitutions, perform_substitutions, truth

# ids of lifecycle_msgs/msg/Transition
CREATE, CONFIGURE, CLEANUP, ACTIVATE, DEACTIVATE = 0, 1, 2, 3, 4
UNCONFIGURED_SHUTDOWN, INACTIVE_SHUTDOWN, ACTIVE_SHUTDOWN, DESTROY = 5, 6, 7, 8
TRANSITIONS = {
    CREATE: 'TRANSITION_CREATE',
    CONFIGURE: 'TRANSITION_CONFIGURE',
    CLEANUP: 'TRANSITION_CLEANUP',
    ACTIVATE: 'TRANSITION_ACTIVATE',
    DEACTIVATE: 'TRANSITION_DEACTIVATE',
    UNCONFIGURED_SHUTDOWN: 'TRANSITION_UNCONFIGURED_SHUTDOWN',
    INACTIVE_SHUTDOWN: 'TRANSITION_INACTIVE_SHUTDOWN',
    ACTIVE_SHUTDOWN: 'TRANSITION_ACTIVE_SHUTDOWN',
    DESTROY: 'TRANSITION_DESTROY',
}
_WAY = {
    CONFIGURE: ('configuring', 'inactive'),
    CLEANUP: ('cleaningup', 'unconfigured'),
    ACTIVATE: ('activating', 'active'),
    DEACTIVATE: ('deactivating', 'inactive'),
    UNCONFIGURED_SHUTDOWN: ('shuttingdown', 'finalized'),
    INACTIVE_SHUTDOWN: ('shuttingdown', 'finalized'),
    ACTIVE_SHUTDOWN: ('shuttingdown', 'finalized'),
}


class ChangeState(Event):
    """An event that asks the matching managed nodes to make a transition."""

    name = 'launch_ros.events.lifecycle.ChangeState'
    valid_transitions = TRANSITIONS

    def __init__(self, *, lifecycle_node_matcher: Callable[[Any], bool], transition_id: int) -> None:
        if transition_id not in TRANSITIONS:
            known = ', '.join(f'{text}: {number}' for number, text in TRANSITIONS.items())
            raise ValueError(f'there is no transition {transition_id!r}; known are {known}')
        self.lifecycle_node_matcher = lifecycle_node_matcher
        self.transition_id = transition_id


class StateTransition(Event):
    """The event that a managed node has changed its state; `msg` is the received TransitionEvent."""

    name = 'launch_ros.events.lifecycle.StateTransition'

    def __init__(self, *, action: Any, msg: Any) -> None:
        self.action = action
        self.msg = msg

    @property
    def timestamp(self) -> int:
        return int(self.msg.timestamp)

    @property
    def transition(self) -> str:
        return str(self.msg.transition.label)

    @property
    def start_state(self) -> str:
        return str(self.msg.start_state.label)

    @property
    def goal_state(self) -> str:
        return str(self.msg.goal_state.label)


def matches_node_name(node_name: str) -> Callable[[Any], bool]:
    """Return a function that matches the action of a node with this full name."""
    wanted = node_name if node_name.startswith('/') else f'/{node_name}'
    return lambda action: action.node_name == wanted


class OnStateTransition(EventHandler):
    """Handles changes of state of one managed node, or of any."""

    def __init__(
        self,
        *,
        entities: SomeEntities,
        target_lifecycle_node: Any = None,
        transition: str | None = None,
        start_state: str | None = None,
        goal_state: str | None = None,
        matcher: Callable[[Event], bool] | None = None,
        **options: Any,
    ) -> None:
        wanted = {'transition': transition, 'start_state': start_state, 'goal_state': goal_state}
        if matcher is not None and (target_lifecycle_node is not None or any(wanted.values())):
            raise LaunchError('OnStateTransition takes either `matcher` or the other criteria, not both')

        def matches(event: Event) -> bool:
            return (
                isinstance(event, StateTransition)
                and (target_lifecycle_node is None or event.action is target_lifecycle_node)
                and all(value is None or getattr(event, name) == value for name, value in wanted.items())
            )

        self._wanted = ', '.join(f'{name}={value}' for name, value in wanted.items() if value)
        super().__init__(matcher=matcher or matches, entities=entities, **options)

    @property
    def matcher_description(self) -> str:
        return f'event is StateTransition {self._wanted}'.strip()


async def _hear(own: LaunchNode, action: LifecycleNode, ready: asyncio.Future[Any]) -> None:
    """Emit an event for each message on a node's ~/transition_event. Complete `ready` once subscribed."""
    from lifecycle_msgs.msg import TransitionEvent

    try:
        node = await own.wait_open()
        subscription = node.subscription(TransitionEvent, f'{action.node_name}/transition_event')
    except Exception as error:
        ready.set_exception(error)
        return
    ready.set_result(subscription)
    async for message in subscription:
        own.context.emit_event_sync(StateTransition(action=action, msg=message))


async def _change(
    own: LaunchNode, action: LifecycleNode, transition: int, ready: asyncio.Future[Any]
) -> None:
    """Wait for a managed node, and ask it to make a transition."""
    from lifecycle_msgs.srv import ChangeState as Service

    transitions = await asyncio.shield(ready)
    client = await own.client(Service, f'{action.node_name}/change_state')
    request = Service.Request()
    request.transition.id = transition
    what = f"Failed to make transition '{TRANSITIONS[transition]}' for LifecycleNode '{action.node_name}'"
    try:
        await client.wait_for_server()
        await transitions.wait_for_publishers()  # so that its event is not missed
        response = await client.call(request)
    except CallError as error:
        get_logger('launch_ros').error(f'{what}: {error}')
        return
    if not response.success:
        get_logger('launch_ros').error(what)


@expose_action('lifecycle_node')
class LifecycleNode(Node):
    """Runs a managed node. Its transitions become StateTransition events; ChangeState events request them."""

    def __init__(
        self,
        *,
        name: SomeSubstitutions,
        namespace: SomeSubstitutions,
        autostart: bool | SomeSubstitutions = False,
        **options: Any,
    ) -> None:
        super().__init__(name=name, namespace=namespace, **options)
        self._autostart = autostart
        self._ready: asyncio.Future[Any] | None = None

    @classmethod
    def parse(
        cls, entity: Entity, parser: Parser, ignore: Iterable[str] = ()
    ) -> tuple[type[Action], dict[str, Any]]:
        _, arguments = super().parse(entity, parser, ignore)
        for needed in ('name', 'namespace'):
            if needed not in arguments:
                raise LaunchError(f"<lifecycle_node> needs the attribute '{needed}'")
        autostart = entity.get_attr('autostart', data_type=bool, optional=True)
        if autostart is not None:
            arguments['autostart'] = parser.parse_if_substitutions(autostart)
        return cls, arguments

    @property
    def is_lifecycle_node(self) -> bool:
        return True

    @property
    def node_autostart(self) -> bool | SomeSubstitutions:
        return self._autostart

    def execute(self, context: LaunchContext) -> Any:
        if context.is_shutdown:
            return None
        self.expand_names(context)
        own = LaunchNode.of(context)
        ready = context.asyncio_loop.create_future()
        self._ready = ready
        _ = own.start(_hear(own, self, ready))
        context.register_event_handler(
            EventHandler(
                matcher=lambda event: isinstance(event, ChangeState) and event.lifecycle_node_matcher(self),
                entities=OpaqueFunction(function=partial(self._ask, own=own, ready=ready)),
            )
        )
        done = super().execute(context)
        autostart = self._autostart
        if not isinstance(autostart, bool):
            autostart = truth(context, autostart)
        if autostart:
            return [
                LifecycleTransition(
                    lifecycle_node_names=[self.node_name], transition_ids=[CONFIGURE, ACTIVATE]
                )
            ]
        return done

    def _ask(self, context: LaunchContext, own: LaunchNode, ready: asyncio.Future[Any]) -> None:
        event = context.locals.event
        task = own.start(_change(own, self, event.transition_id, ready))
        context.add_completion_future(task)

        def abandon(_: LaunchContext) -> None:
            if not task.done():
                get_logger('launch_ros').warning(
                    f"Abandoning the '{self.node_name}/change_state' service, due to shutdown."
                )
                task.cancel()

        context.register_event_handler(
            EventHandler(
                matcher=lambda event: isinstance(event, Shutdown),
                entities=OpaqueFunction(function=abandon),
                handle_once=True,
            )
        )


@expose_action('lifecycle_transition')
class LifecycleTransition(Action):
    """Takes managed nodes through a sequence of transitions; each begins when the previous one has ended."""

    def __init__(
        self,
        *,
        lifecycle_node_names: Iterable[SomeSubstitutions],
        transition_ids: Iterable[int | SomeSubstitutions],
        **options: Any,
    ) -> None:
        super().__init__(**options)
        self._names = [normalize_to_list_of_substitutions(name) for name in lifecycle_node_names]
        self._ids = [
            normalize_to_list_of_substitutions(str(item) if isinstance(item, int) else item)
            for item in transition_ids
        ]
        if not self._names or not self._ids:
            raise BadLaunchValueError('LifecycleTransition needs names of nodes and transitions')

    @classmethod
    def parse(cls, entity: Entity, parser: Parser) -> tuple[type[Action], dict[str, Any]]:
        _, arguments = super().parse(entity, parser)
        names, ids = entity.get_attr('lifecycle_node_names'), entity.get_attr('transition_ids')
        arguments['lifecycle_node_names'] = [parser.parse_substitution(name) for name in names.split()]
        arguments['transition_ids'] = [parser.parse_substitution(item) for item in ids.split()]
        return cls, arguments

    def execute(self, context: LaunchContext) -> list[Action]:
        names = [perform_substitutions(context, name) for name in self._names]
        texts = [perform_substitutions(context, item) for item in self._ids]
        if not all(text.isdecimal() and int(text) in _WAY for text in texts):
            raise LaunchError(f'transitions are given by number, {sorted(_WAY)}, not as {texts}')
        return [
            action for name in names for action in self._way(context, name, [int(text) for text in texts])
        ]

    def _way(self, context: LaunchContext, name: str, transitions: list[int]) -> list[Action]:
        """Return the actions that ask for the first transition and, after each transition, for the next."""
        full = name if name.startswith('/') else f'/{name}'
        handlers: list[EventHandler] = []

        def stop(context: LaunchContext, reason: str | None = None) -> None:
            if reason:
                get_logger('launch_ros').info(f'Stopping transitions for {full}: {reason}')
            for handler in handlers:
                if handler in context.handlers:
                    context.unregister_event_handler(handler)

        def reached(event: Event, transition: int) -> bool:
            start, goal = _WAY[transition]
            return (
                isinstance(event, StateTransition)
                and event.action.node_name == full
                and (event.start_state, event.goal_state) == (start, goal)
            )

        def failed(event: Event) -> bool:
            return (
                isinstance(event, StateTransition)
                and event.action.node_name == full
                and event.goal_state == 'errorprocessing'
            )

        asks = [
            EmitEvent(event=ChangeState(lifecycle_node_matcher=matches_node_name(full), transition_id=number))
            for number in transitions
        ]
        for position, number in enumerate(transitions):
            last = position == len(transitions) - 1
            following: Action = OpaqueFunction(function=stop) if last else asks[position + 1]
            handlers.append(
                EventHandler(
                    matcher=partial(reached, transition=number), entities=following, handle_once=True
                )
            )
        handlers.append(
            EventHandler(
                matcher=failed,
                entities=OpaqueFunction(function=stop, kwargs={'reason': 'an error occurred'}),
                handle_once=True,
            )
        )
        first, *others = [RegisterEventHandler(handler) for handler in handlers]
        return [first, asks[0], *others]  # asks[0] only queues an event, so `others` are registered in time
