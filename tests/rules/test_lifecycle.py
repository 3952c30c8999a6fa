"""The table of a managed node's life is rcl_lifecycle's, and the machine follows it."""

from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st

from goalwire.rules import lifecycle
from goalwire.rules.lifecycle import STATES, TRANSITIONS, LifecycleMachine, LifecycleState
from goalwire.rules.lifecycle import TransitionCallbackReturnType as Outcome

GRAPH = """
1 configure unconfigured configuring
10 transition_success configuring inactive
11 transition_failure configuring unconfigured
12 transition_error configuring errorprocessing
2 cleanup inactive cleaningup
20 transition_success cleaningup unconfigured
21 transition_failure cleaningup inactive
22 transition_error cleaningup errorprocessing
3 activate inactive activating
30 transition_success activating active
31 transition_failure activating inactive
32 transition_error activating errorprocessing
4 deactivate active deactivating
40 transition_success deactivating inactive
41 transition_failure deactivating active
42 transition_error deactivating errorprocessing
5 shutdown unconfigured shuttingdown
6 shutdown inactive shuttingdown
7 shutdown active shuttingdown
50 transition_success shuttingdown finalized
51 transition_failure shuttingdown finalized
52 transition_error shuttingdown errorprocessing
60 transition_success errorprocessing unconfigured
61 transition_failure errorprocessing finalized
62 transition_error errorprocessing finalized
"""
"""The answer of ROS 2 Jazzy's get_transition_graph, in its order."""

IDS = {
    'unknown': 0,
    'unconfigured': 1,
    'inactive': 2,
    'active': 3,
    'finalized': 4,
    'configuring': 10,
    'cleaningup': 11,
    'shuttingdown': 12,
    'activating': 13,
    'deactivating': 14,
    'errorprocessing': 15,
}
RESTING = {'unconfigured', 'inactive', 'active', 'finalized'}


def machine_in(state: LifecycleState) -> LifecycleMachine:
    machine = LifecycleMachine()
    machine.state = state
    return machine


def test_the_transitions_are_those_of_ros_2_in_its_order() -> None:
    lines = [f'{found.id} {found.label} {found.start.label} {found.goal.label}' for found in TRANSITIONS]
    assert lines == GRAPH.split('\n')[1:-1]


def test_the_states_are_those_of_ros_2_in_its_order() -> None:
    assert [(state.label, state.state_id) for state in STATES] == list(IDS.items())


def test_a_node_begins_unconfigured() -> None:
    state = LifecycleMachine().state
    assert (state.state_id, state.label) == (1, 'unconfigured')


@pytest.mark.parametrize('state', STATES, ids=lambda state: state.label)
def test_a_transition_begins_where_the_graph_says_so_and_nowhere_else(state: LifecycleState) -> None:
    rows = [line.split() for line in GRAPH.strip().split('\n')]
    begins = {
        key: goal
        for number, label, start, goal in rows
        if start == state.label and start in RESTING
        for key in (int(number), label)
    }
    for wanted in [*range(100), *{label for _, label, _, _ in rows}, '', 'nonsense']:
        machine = machine_in(state)
        begun = machine.begin(wanted)
        assert (begun and begun.goal.label) == begins.get(wanted)
        assert machine.state.label == begins.get(wanted, state.label)


@pytest.mark.parametrize(
    ('requests', 'outcomes', 'state'),
    [
        (['configure'], 'S', 'inactive'),
        (['configure'], 'F', 'unconfigured'),
        (['configure'], 'ES', 'unconfigured'),
        (['configure'], 'EF', 'finalized'),
        (['configure'], 'EE', 'finalized'),
        (['configure', 'activate'], 'SS', 'active'),
        (['configure', 'activate'], 'SF', 'inactive'),
        (['configure', 'activate'], 'SEE', 'finalized'),
        (['configure', 'activate'], 'SES', 'unconfigured'),
        (['configure', 'activate', 'deactivate'], 'SSF', 'active'),
        (['configure', 'activate', 'deactivate'], 'SSS', 'inactive'),
        (['configure', 'activate', 'shutdown'], 'SSS', 'finalized'),
        (['configure', 'cleanup'], 'SS', 'unconfigured'),
        (['configure', 'cleanup'], 'SF', 'inactive'),
        (['shutdown'], 'S', 'finalized'),
        (['shutdown'], 'F', 'finalized'),
        (['shutdown'], 'ES', 'unconfigured'),
    ],
)
def test_outcomes_lead_where_ros_2_goes(requests: list[str], outcomes: str, state: str) -> None:
    machine = LifecycleMachine()
    said = iter([{'S': Outcome.SUCCESS, 'F': Outcome.FAILURE, 'E': Outcome.ERROR}[one] for one in outcomes])
    for request in requests:
        transition = machine.begin(request)
        assert transition
        while transition.callback:
            transition = machine.end(next(said))
    assert machine.state.label == state
    assert list(said) == []


@given(st.lists(st.tuples(st.sampled_from(TRANSITIONS), st.sampled_from(Outcome), st.sampled_from(Outcome))))
def test_every_walk_comes_to_rest_after_two_callbacks_at_most(
    walk: list[tuple[lifecycle.Transition, Outcome, Outcome]],
) -> None:
    machine = LifecycleMachine()
    for request, first, second in walk:
        transition = machine.begin(request.id)
        if transition is None:
            continue
        assert transition.callback == f'on_{transition.label}'
        transition = machine.end(first)
        if first is Outcome.ERROR:
            assert transition.callback == 'on_error'
            transition = machine.end(second)
        assert transition.callback is None
        assert machine.state.label in RESTING


def test_outcomes_are_those_of_rclpy() -> None:
    assert repr(Outcome.SUCCESS) == '<TransitionCallbackReturnType.SUCCESS: 97>'
    assert str(Outcome.ERROR) == 'TransitionCallbackReturnType.ERROR'
    assert [int(outcome) for outcome in Outcome] == [97, 98, 99]
    assert Outcome(98).to_label() == 'transition_failure'
