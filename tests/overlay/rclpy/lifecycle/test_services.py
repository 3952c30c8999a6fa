"""The services and the event topic by which a managed node shows itself and is driven."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import Any

import pytest
from helpers.collector import Collector
from helpers.patience import PATIENCE
from helpers.spinning import Spinner, result_of
from lifecycle_msgs.msg import Transition, TransitionEvent
from lifecycle_msgs.srv import ChangeState, GetAvailableStates, GetAvailableTransitions, GetState
from rclpy.callback_groups import ReentrantCallbackGroup
from rclpy.client import Client
from rclpy.context import Context
from rclpy.executors import Executor
from rclpy.lifecycle import LifecycleNode, LifecycleNodeMixin, LifecycleState, TransitionCallbackReturn
from rclpy.node import Node
from rclpy.qos import DurabilityPolicy, ReliabilityPolicy

from goalwire.rules.lifecycle import STATES, TRANSITIONS

Call = Callable[..., Any]

TYPES: dict[str, Any] = {
    'change_state': ChangeState,
    'get_state': GetState,
    'get_available_states': GetAvailableStates,
    'get_available_transitions': GetAvailableTransitions,
    'get_transition_graph': GetAvailableTransitions,
}


@pytest.fixture
def peer(context: Context) -> Node:
    return Node('peer', context=context)


@pytest.fixture
def managed(context: Context) -> LifecycleNode:
    return LifecycleNode('managed', namespace='lab', context=context)


@pytest.fixture
def call(executor: Executor, managed: LifecycleNode, peer: Node) -> Iterator[Call]:
    """Call a service of the managed node by its name: `call('get_state')`; both nodes spin."""
    clients: dict[str, Client[Any, Any]] = {
        name: peer.create_client(srv_type, f'/lab/managed/{name}') for name, srv_type in TYPES.items()
    }

    def ask(name: str, request: object = None) -> Any:
        assert clients[name].wait_for_service(10)
        return result_of(clients[name].call_async(request or TYPES[name].Request()))

    with Spinner(executor, managed, peer):
        yield ask


def change(call: Call, **transition: Any) -> bool:
    answer: bool = call('change_state', ChangeState.Request(transition=Transition(**transition))).success
    return answer


def state_of(call: Call) -> tuple[int, str]:
    state = call('get_state').current_state
    return state.id, state.label


def test_a_manager_drives_the_node_by_id_and_by_label(call: Call) -> None:
    assert state_of(call) == (1, 'unconfigured')
    assert change(call, id=Transition.TRANSITION_CONFIGURE)
    assert state_of(call) == (2, 'inactive')
    assert change(call, label='activate')
    assert state_of(call) == (3, 'active')
    assert change(call, id=Transition.TRANSITION_CONFIGURE, label='shutdown'), 'a label is stronger'
    assert state_of(call) == (4, 'finalized')


@pytest.mark.parametrize(
    ('transition', 'shown'),
    [({'id': 3}, '3'), ({'id': 99}, '99'), ({'id': 10}, '10'), ({'id': 1, 'label': 'nonsense'}, 'nonsense')],
    ids=['activate', 'unknown', 'outcome', 'label'],
)
def test_what_is_no_transition_is_answered_with_no_success_and_the_node_lives_on(
    call: Call, capfd: pytest.CaptureFixture[str], transition: dict[str, Any], shown: str
) -> None:
    assert change(call, **transition) is False
    logged = capfd.readouterr().err
    assert f'[rcl_lifecycle]: No transition matching {shown} found for current state unconfigured' in logged
    assert f'[lab.managed]: Unable to start transition {shown}' in logged
    assert "From 'unconfigured' there are: 'configure' (1), 'shutdown' (5)" in logged
    assert change(call, label='configure')


def test_a_callback_that_fails_is_no_success(
    call: Call, managed: LifecycleNode, monkeypatch: pytest.MonkeyPatch
) -> None:
    for answer, state in [
        (TransitionCallbackReturn.FAILURE, (1, 'unconfigured')),
        (TransitionCallbackReturn.ERROR, (1, 'unconfigured')),
        (None, (1, 'unconfigured')),
    ]:
        monkeypatch.setattr(managed, 'on_configure', lambda _, answer=answer: answer)
        assert change(call, label='configure') is False
        assert state_of(call) == state


def test_the_node_tells_its_states_and_transitions(call: Call) -> None:
    states = call('get_available_states').available_states
    assert [(state.label, state.id) for state in states] == list(STATES)
    graph = call('get_transition_graph').available_transitions
    assert [_plain(description) for description in graph] == [
        (*found[:2], *reversed(found.start), *reversed(found.goal)) for found in TRANSITIONS
    ]
    change(call, label='configure')
    assert [_plain(found) for found in call('get_available_transitions').available_transitions] == [
        (2, 'cleanup', 2, 'inactive', 11, 'cleaningup'),
        (3, 'activate', 2, 'inactive', 13, 'activating'),
        (6, 'shutdown', 2, 'inactive', 12, 'shuttingdown'),
    ]


def _plain(event: Any) -> tuple[int, str, int, str, int, str]:
    transition, start, goal = event.transition, event.start_state, event.goal_state
    return transition.id, transition.label, start.id, start.label, goal.id, goal.label


def test_every_step_is_an_event_with_its_time(
    call: Call, managed: LifecycleNode, peer: Node, monkeypatch: pytest.MonkeyPatch
) -> None:
    events: Collector[TransitionEvent] = Collector()
    peer.create_subscription(TransitionEvent, '/lab/managed/transition_event', events, 10)
    before = managed.get_clock().now().nanoseconds
    change(call, label='configure')
    monkeypatch.setattr(managed, 'on_activate', lambda _: TransitionCallbackReturn.ERROR)
    change(call, label='activate')
    assert [_plain(event) for event in events.expect(5)] == [
        (1, 'configure', 1, 'unconfigured', 10, 'configuring'),
        (10, 'transition_success', 10, 'configuring', 2, 'inactive'),
        (3, 'activate', 2, 'inactive', 13, 'activating'),
        (32, 'transition_error', 13, 'activating', 15, 'errorprocessing'),
        (60, 'transition_success', 15, 'errorprocessing', 1, 'unconfigured'),
    ]
    stamps = [event.timestamp for event in events.items]
    assert [before, *stamps] == sorted([before, *stamps])
    assert stamps[-1] <= managed.get_clock().now().nanoseconds


def test_the_endpoints_are_those_of_ros_2(managed: LifecycleNode) -> None:
    names = [service.srv_name for service in managed.services if service.srv_name.startswith('/')]
    assert names == [f'/lab/managed/{name}' for name in TYPES]
    types = {service.service_name: service.srv_type for service in managed.services}
    assert {f'/lab/managed/{name}': srv_type for name, srv_type in TYPES.items()}.items() <= types.items()
    assert '/lab/managed/transition_event' not in [publisher.topic_name for publisher in managed.publishers]
    (info,) = managed.get_publishers_info_by_topic('/lab/managed/transition_event')
    assert info.topic_type == 'lifecycle_msgs/msg/TransitionEvent'
    assert info.qos_profile.reliability is ReliabilityPolicy.RELIABLE
    assert info.qos_profile.durability is DurabilityPolicy.VOLATILE


def test_without_the_communication_interface_there_are_events_alone(context: Context) -> None:
    quiet = LifecycleNode('quiet', context=context, enable_communication_interface=False)
    services = dict(quiet.get_service_names_and_types_by_node('quiet', '/'))
    assert not {f'/quiet/{name}' for name in TYPES} & services.keys()
    assert not {f'/quiet/{name}' for name in TYPES} & {service.srv_name for service in quiet.services}
    assert quiet.count_publishers('/quiet/transition_event') == 1
    assert quiet.trigger_configure() is TransitionCallbackReturn.SUCCESS


def test_a_destroyed_node_takes_its_endpoints_along(context: Context, peer: Node) -> None:
    LifecycleNode('gone', context=context).destroy_node()
    assert peer.count_publishers('/gone/transition_event') == 0
    assert peer.count_services('/gone/get_state') == 0


def test_a_node_in_transition_tells_its_state_and_lets_no_other_begin(
    context: Context, peer: Node, spin: Callable[..., Spinner]
) -> None:
    answers: list[object] = []

    class Asked(Node, LifecycleNodeMixin):
        """Asks itself, through its services, while it is being configured."""

        def __init__(self) -> None:
            Node.__init__(self, 'asked', context=context)
            LifecycleNodeMixin.__init__(self, callback_group=ReentrantCallbackGroup())

        def on_configure(self, state: LifecycleState) -> TransitionCallbackReturn:
            answers.append(state_of(ask))
            answers.append(change(ask, id=Transition.TRANSITION_ON_CONFIGURE_FAILURE))
            answers.append(change(ask, label='shutdown'))
            labels = [
                found.transition.label for found in ask('get_available_transitions').available_transitions
            ]
            answers.append(labels)
            return TransitionCallbackReturn.SUCCESS

    def ask(name: str, request: object = None) -> Any:
        client = peer.create_client(TYPES[name], f'/asked/{name}')
        assert client.wait_for_service(10)
        return client.call(request or TYPES[name].Request(), timeout_sec=PATIENCE)

    spin(Asked(), threads=4)
    assert change(ask, label='configure')
    outcomes = ['transition_success', 'transition_failure', 'transition_error']
    assert answers == [(10, 'configuring'), False, False, outcomes]
    assert state_of(ask) == (2, 'inactive')
