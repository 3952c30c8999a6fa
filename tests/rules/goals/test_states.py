from __future__ import annotations

import pytest

from goalwire.errors import InvalidTransition
from goalwire.rules.goals import TABLE, GoalEvent, GoalStatus
from goalwire.rules.goals.states import after

ALLOWED = {
    ('ACCEPTED', 'EXECUTE'): 'EXECUTING',
    ('ACCEPTED', 'CANCEL_GOAL'): 'CANCELING',
    ('EXECUTING', 'CANCEL_GOAL'): 'CANCELING',
    ('EXECUTING', 'SUCCEED'): 'SUCCEEDED',
    ('EXECUTING', 'ABORT'): 'ABORTED',
    ('CANCELING', 'SUCCEED'): 'SUCCEEDED',
    ('CANCELING', 'ABORT'): 'ABORTED',
    ('CANCELING', 'CANCELED'): 'CANCELED',
}


def test_the_transitions_are_those_of_rcl_action_and_no_other() -> None:
    found = {
        (status.name, event.name): after(status, event).name
        for status in TABLE
        for event in GoalEvent
        if event in TABLE[status]
    }
    assert found == ALLOWED


@pytest.mark.parametrize('status', list(GoalStatus))
@pytest.mark.parametrize('event', list(GoalEvent))
def test_whatever_the_table_does_not_name_is_refused(status: GoalStatus, event: GoalEvent) -> None:
    if (status.name, event.name) in ALLOWED:
        return
    with pytest.raises(InvalidTransition) as raised:
        after(status, event)
    assert str(raised.value) == (
        'Failed to update goal state: goal_handle attempted invalid transition '
        f'from state {status.name} with event {event.name}'
    )


def test_every_state_is_active_terminal_or_unknown() -> None:
    assert [status.name for status in GoalStatus if status.is_active] == [
        'ACCEPTED',
        'EXECUTING',
        'CANCELING',
    ]
    assert [status.name for status in GoalStatus if status.is_terminal] == [
        'SUCCEEDED',
        'CANCELED',
        'ABORTED',
    ]
    assert [status.name for status in GoalStatus if status.is_cancelable] == ['ACCEPTED', 'EXECUTING']


def test_numbers_grow_along_every_path_of_the_table() -> None:
    # The client tells an older status from a newer one by this.
    assert all(later > status for status, events in TABLE.items() for later in events.values())


def test_nothing_leaves_a_terminal_state() -> None:
    assert all(not TABLE[status] for status in GoalStatus if status.is_terminal)


def test_numbers_are_those_of_the_wire() -> None:
    assert [status.value for status in GoalStatus] == list(range(7))
    assert [event.name for event in GoalEvent] == ['EXECUTE', 'CANCEL_GOAL', 'SUCCEED', 'ABORT', 'CANCELED']
