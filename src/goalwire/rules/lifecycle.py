"""The life of a managed node: its states, the transitions between them, and what a callback's outcome does.

States, ids, labels and their order are those of rcl_lifecycle's default state machine:

    unconfigured --configure--> configuring --success--> inactive       failure: unconfigured again
    inactive     --cleanup----> cleaningup  --success--> unconfigured   failure: inactive again
    inactive     --activate---> activating  --success--> active         failure: inactive again
    active       --deactivate-> deactivating -success--> inactive       failure: active again
    these three  --shutdown---> shuttingdown -success--> finalized      failure: finalized, too
    an error in any of these:   errorprocessing -success-> unconfigured failure, error: finalized

A node rests in the primary states. During a transition it is in one of the others, and its callback runs.
"""

from __future__ import annotations

from enum import Enum
from typing import NamedTuple


class TransitionCallbackReturnType(Enum):
    """How a transition callback ended. The numbers are lifecycle_msgs' TRANSITION_CALLBACK_…"""

    SUCCESS = 97
    FAILURE = 98
    ERROR = 99

    def to_label(self) -> str:
        """The label of the transition that follows: 'transition_success' and so on."""
        return f'transition_{self.name.lower()}'

    def __int__(self) -> int:
        return self.value

    def __str__(self) -> str:
        return f'{type(self).__name__}.{self.name}'


class LifecycleState(NamedTuple):
    """A state, in the form that callbacks get."""

    label: str
    state_id: int

    @property
    def is_primary(self) -> bool:
        """True if a node may rest; False while a transition's callback runs."""
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
    """A way from one state to another."""

    id: int
    label: str
    start: LifecycleState
    goal: LifecycleState

    @property
    def callback(self) -> str | None:
        """The name of the callback that decides how it goes on; None if the node now rests."""
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
    """The three ways out of a state whose callback has returned; ids count from `first_id`."""
    goals = (success, failure, error)
    return [
        Transition(number, outcome.to_label(), start, goal)
        for number, (outcome, goal) in enumerate(
            zip(TransitionCallbackReturnType, goals, strict=True), first_id
        )
    ]


CONFIGURE, CLEANUP, ACTIVATE, DEACTIVATE = 1, 2, 3, 4
"""Ids to ask for. To shut down has one for each state: ask for the label."""

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
    """Where one node is in its life. Pure: no lock, no I/O.

    `begin` a transition, run the callback that it names, `end` it with the outcome; that may name a callback
    again (on_error), until the node rests.
    """

    def __init__(self) -> None:
        self.state = UNCONFIGURED

    @property
    def current_state(self) -> tuple[int, str]:
        """Id and label, as rclpy's machine has them: programs read it, as a node has no public one."""
        return self.state.state_id, self.state.label

    @property
    def possible(self) -> list[Transition]:
        """The transitions that start in the present state."""
        return [transition for transition in TRANSITIONS if transition.start == self.state]

    def begin(self, wanted: int | str) -> Transition | None:
        """Start the transition of this id or label; None if there is none from here.

        During a transition there is none: how that ends is for its callback to say, not for a peer.
        """
        if not self.state.is_primary:
            return None
        for transition in self.possible:
            if wanted in {transition.id, transition.label}:
                return self._go(transition)
        return None

    def end(self, outcome: TransitionCallbackReturnType) -> Transition:
        """Go on as the callback said. To be called between `begin` and rest only."""
        label = outcome.to_label()
        return self._go(next(found for found in self.possible if found.label == label))

    def _go(self, transition: Transition) -> Transition:
        self.state = transition.goal
        return transition
