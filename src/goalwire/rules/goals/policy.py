"""Goal policies: how many goals a server runs at a time, and what happens to the others.

| policy        | at once | wait for their turn | one too many               |
|---------------|---------|---------------------|----------------------------|
| `UNLIMITED`   | any     | none                | there is none              |
| `parallel(n)` | n       | none                | is refused                 |
| `single()`    | 1       | none                | is refused                 |
| `queue(n)`    | 1       | n                   | is refused                 |
| `preempt()`   | 1       | the latest          | cancels those before it    |

A waiting goal is ACCEPTED, and becomes EXECUTING when its turn comes. If it is cancelled while it waits, it
ends at once. A running goal keeps its place until its execute callback has returned, even if the callback has
set the goal's final state earlier.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Generic, Literal, TypeAlias, TypeVar, get_args

from goalwire.records import record

if TYPE_CHECKING:
    from goalwire.rules.goals.ids import GoalId

GoalT = TypeVar('GoalT')

OnClientLost: TypeAlias = Literal['keep', 'cancel', 'abort']
"""A server's policy for the goals of a lost client. ROS 2's servers keep such goals."""

ON_CLIENT_LOST: tuple[str, ...] = get_args(OnClientLost)


@record
class GoalPolicy:
    """A goal policy, made by `parallel`, `single`, `preempt` or `queue`.

    Raises TypeError for numbers of another type, ValueError for numbers out of range.
    """

    at_once: int | None = None
    """The most goals that run at a time; None: any number."""
    waiting: int = 0
    """The most goals that wait for their turn beside them."""
    preempts: bool = False
    """True if a new goal cancels the earlier goals instead of waiting for their end."""

    def __post_init__(self) -> None:
        for number in (self.at_once, self.waiting):
            if number is not None and not isinstance(number, int):
                raise TypeError(f'a number of goals is an int, not {number!r}')
        if self.at_once is not None and self.at_once < 1:
            raise ValueError(f'a server runs at least 1 goal at a time, not {self.at_once}')
        if self.waiting < 0:
            raise ValueError(f'at least 0 goals wait for their turn, not {self.waiting}')


def check_policies(policy: GoalPolicy, on_client_lost: OnClientLost) -> None:
    """Raise TypeError if `policy` is not a GoalPolicy, ValueError for an unknown `on_client_lost`."""
    if not isinstance(policy, GoalPolicy):
        raise TypeError(f'policy is what goalwire.single(), preempt(), … return, not {policy!r}')
    if on_client_lost not in ON_CLIENT_LOST:
        known = ' or '.join(map(repr, ON_CLIENT_LOST))
        raise ValueError(f'on_client_lost is {known}, not {on_client_lost!r}')


UNLIMITED = GoalPolicy()
"""ROS 2's own policy: every goal runs at once."""


def parallel(n: int) -> GoalPolicy:
    """Run up to `n` goals at the same time; refuse further goals."""
    return GoalPolicy(n)


def single() -> GoalPolicy:
    """Run one goal at a time; refuse other goals meanwhile."""
    return GoalPolicy(1)


def preempt() -> GoalPolicy:
    """Run the latest goal: a new goal cancels the running goal, and starts when that goal has ended."""
    return GoalPolicy(1, 1, preempts=True)


def queue(n: int) -> GoalPolicy:
    """Run one goal after the other; let up to `n` goals wait for their turn, and refuse more."""
    return GoalPolicy(1, n)


class Places(Generic[GoalT]):
    """The places of a policy: which goals run, and which wait for their turn."""

    def __init__(self, policy: GoalPolicy) -> None:
        self.policy = policy
        self.unfinished: dict[GoalId, GoalT] = {}
        """Goals from their acceptance to the end of their execution, in the order of acceptance."""
        self.running = 0
        self.waiting: dict[GoalId, GoalT] = {}
        """The waiting goals in the order of their turns."""

    @property
    def are_taken(self) -> bool:
        """True if a further goal would be refused."""
        policy = self.policy
        if policy.at_once is None or policy.preempts:
            return False
        return len(self.unfinished) >= policy.at_once + policy.waiting

    @property
    def has_room(self) -> bool:
        """True if a further goal may run now."""
        return self.policy.at_once is None or self.running < self.policy.at_once

    def next(self) -> GoalT | None:
        """Remove and return the waiting goal whose turn it is; None if no goal waits, or no place is free."""
        if not self.waiting or not self.has_room:
            return None
        return self.waiting.pop(next(iter(self.waiting)))

    def clear(self) -> None:
        """Discard all goals."""
        self.running = 0
        self.unfinished.clear()
        self.waiting.clear()
