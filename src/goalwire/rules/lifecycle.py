"""The life cycle of a managed node: its states, its transitions, and the effect of a callback's outcome.

States, ids, labels and their order are those of rcl_lifecycle's default state machine:

    unconfigured --configure--> configuring --success--> inactive       failure: unconfigured again
    inactive     --cleanup----> cleaningup  --success--> unconfigured   failure: inactive again
    inactive     --activate---> activating  --success--> active         failure: inactive again
    active       --deactivate-> deactivating -success--> inactive       failure: active again
    these three  --shutdown---> shuttingdown -success--> finalized      failure: finalized, too
    an error in any of these:   errorprocessing -success-> unconfigured failure, error: finalized

A node rests in a primary state. In every other state a transition is under way, and its callback runs.
"""

from __future__ import annotations

from enum import Enum
from typing import NamedTuple


class TransitionCallbackReturnType(Enum):
    """The outcome of a transition callback. The numbers are lifecycle_msgs' TRANSITION_CALLBACK_…"""

    SUCCESS = 97
    FAILURE = 98
    ERROR = 99

    def to_label(self) -> str:
        """Return the label of the transition that follows this outcome: 'transition_success' and so on."""
        return f'transition_{self.name.lower()}'

    def __int__(self) -> int:
        return self.value

    def __str__(self) -> str:
        return f'{type(self).__name__}.{self.name}'


class LifecycleState(NamedTuple):
    """A state of a managed node, in the form that transition callbacks get."""

    label: str
    state_id: int

    @property
    def is_primary(self) -> bool:
        """True if a node may rest in this state; False if a transition's callback runs in it."""
        return self.state_id < CONFIGURING.state_id


UNKNOWN = LifecycleState('unknown', 0)
UNCONFIGURED = LifecycleState('unconfigured', 1)
INACTIVE = LifecycleState('inactive', 2)
ACTIVE = LifecycleState('active', 3)
FINALIZED = LifecycleState('finalized', 4)
CONFIGURING = LifecycleState('configuring', 10)
CLEANINGUP = LifecycleState('cleaningup', 11)
SHUTTINGDOWN = LifecycleState('shuttingdown', 12)
ACTIVATING = LifecycleState('activating', 13)
DEACTIVATING = LifecycleState('deactivating', 14)
ERRORPROCESSING = LifecycleState('errorprocessing', 15)

STATES = (
    UNKNOWN,
    UNCONFIGURED,
    INACTIVE,
    ACTIVE,
    FINALIZED,
    CONFIGURING,
    CLEANINGUP,
    SHUTTINGDOWN,
    ACTIVATING,
    DEACTIVATING,
    ERRORPROCESSING,
)


class Transition(NamedTuple):
    """A transition from one state to another."""

    id: int
    label: str
    start: LifecycleState
    goal: LifecycleState

    @property
    def callback(self) -> str | None:
        """The name of the callback whose outcome chooses the next transition; None if the node rests."""
        return _CALLBACKS.get(self.goal)


_CALLBACKS = {
    CONFIGURING: 'on_configure',
    CLEANINGUP: 'on_cleanup',
    SHUTTINGDOWN: 'on_shutdown',
    ACTIVATING: 'on_activate',
    DEACTIVATING: 'on_deactivate',
    ERRORPROCESSING: 'on_error',
}


def _outcomes(
    first_id: int,
    start: LifecycleState,
    success: LifecycleState,
    failure: LifecycleState,
    error: LifecycleState,
) -> list[Transition]:
    """Return the transitions for the three outcomes of a state's callback. The ids count from `first_id`."""
    goals = (success, failure, error)
    return [
        Transition(number, outcome.to_label(), start, goal)
        for number, (outcome, goal) in enumerate(
            zip(TransitionCallbackReturnType, goals, strict=True), first_id
        )
    ]


CONFIGURE, CLEANUP, ACTIVATE, DEACTIVATE = 1, 2, 3, 4
"""The ids that users request. For a shutdown they use the label, since each state has another id for it."""

SHUTDOWN = 'shutdown'

TRANSITIONS = (
    Transition(CONFIGURE, 'configure', UNCONFIGURED, CONFIGURING),
    *_outcomes(10, CONFIGURING, INACTIVE, UNCONFIGURED, ERRORPROCESSING),
    Transition(CLEANUP, 'cleanup', INACTIVE, CLEANINGUP),
    *_outcomes(20, CLEANINGUP, UNCONFIGURED, INACTIVE, ERRORPROCESSING),
    Transition(ACTIVATE, 'activate', INACTIVE, ACTIVATING),
    *_outcomes(30, ACTIVATING, ACTIVE, INACTIVE, ERRORPROCESSING),
    Transition(DEACTIVATE, 'deactivate', ACTIVE, DEACTIVATING),
    *_outcomes(40, DEACTIVATING, INACTIVE, ACTIVE, ERRORPROCESSING),
    Transition(5, SHUTDOWN, UNCONFIGURED, SHUTTINGDOWN),
    Transition(6, SHUTDOWN, INACTIVE, SHUTTINGDOWN),
    Transition(7, SHUTDOWN, ACTIVE, SHUTTINGDOWN),
    *_outcomes(50, SHUTTINGDOWN, FINALIZED, FINALIZED, ERRORPROCESSING),
    *_outcomes(60, ERRORPROCESSING, UNCONFIGURED, FINALIZED, FINALIZED),
)


class LifecycleMachine:
    """The present state of one managed node. This class has no lock and no I/O.

    The caller begins a transition by `begin`, runs the callback that `begin` names, and passes the outcome to
    `end`. `end` may name another callback (on_error). The caller repeats these steps until the node rests.
    """

    def __init__(self) -> None:
        self.state = UNCONFIGURED

    @property
    def possible(self) -> list[Transition]:
        """The transitions that are possible in the present state."""
        return [transition for transition in TRANSITIONS if transition.start == self.state]

    def begin(self, wanted: int | str) -> Transition | None:
        """Start the transition with this id or label; None if the present state has no such transition.

        During a transition this method returns None, too, since only the callback's outcome may end a
        transition.
        """
        if not self.state.is_primary:
            return None
        for transition in self.possible:
            if wanted in {transition.id, transition.label}:
                return self._go(transition)
        return None

    def end(self, outcome: TransitionCallbackReturnType) -> Transition:
        """Make the transition that follows the callback's outcome, and return it.

        Only call this during a transition.
        """
        label = outcome.to_label()
        return self._go(next(found for found in self.possible if found.label == label))

    def _go(self, transition: Transition) -> Transition:
        self.state = transition.goal
        return transition
