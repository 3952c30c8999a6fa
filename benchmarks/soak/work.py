"""The work that clients ask for, and its outcomes: of a server that lives, and of one that was killed."""

from __future__ import annotations

from dataclasses import dataclass, replace
from random import Random

ANSWERED = 'answered'
GIVEN_UP = 'given up by its caller'
UNEXPECTED = 'unexpected'

STEADY, MORTAL = ('steady',), ('left', 'right')
"""Servers by name: one that lives to the end, and those that are killed."""
RCLPY = ('right',)
"""Those that are rclpy programs: there, a callback that fails ends the program."""

LOST = frozenset({'NoServerError', 'ServerLostError', 'DeadlineError'})
"""The outcomes that a call may have if its server is killed."""
CLOSED = frozenset({'ServerFailedError', 'GoalAborted', 'GoalCanceled', 'GoalRefused'})
"""The outcomes if the server closes while it works. In one process (memory), a server cannot be killed."""

GRACE_S = 2.0
"""How long a goal that is given up may take to end."""

PATIENCE_S = 10.0
"""The deadline of what should be answered: long, since being busy is not a fault of a machine."""


@dataclass(frozen=True)
class Work:
    """A call or a goal; `ask` tells the server what is to become of it."""

    title: str
    ask: int
    outcome: str
    timeout: float = PATIENCE_S

    @property
    def is_goal(self) -> bool:
        return self.title.startswith('goal')


# The work of a service's handler, in b of AddTwoInts; a is the call's own number.
ADD, FAIL, DAWDLE = 0, 1, 2
# The work of an action's handler, as the order of Fibonacci; a positive order is the number of steps.
REFUSE, ABORT, ENDLESS = -1, 0, 1000

SERVICES = (
    *3 * (Work('service', ADD, ANSWERED),),
    Work('service, handler fails', FAIL, 'ServerFailedError'),
    Work('service, too slow', DAWDLE, 'DeadlineError', 0.2),
)
NOBODY = Work('service of nobody', ADD, 'NoServerError', 0.1)
GOALS = (
    *2 * (Work('goal', 8, ANSWERED),),
    Work('goal, refused', REFUSE, 'GoalRefused'),
    Work('goal, aborted', ABORT, 'GoalAborted'),
    Work('goal, cancelled', ENDLESS, 'GoalCanceled'),
    Work('goal, too slow', ENDLESS, 'DeadlineError', 0.3),
    Work('goal, caller cancelled', ENDLESS, GIVEN_UP),
)
ALL = {work.title: work for work in (*SERVICES, NOBODY, *GOALS)}
PATIENCE_WITH_MORTALS_S = 3.0

STEP_S = 0.01
"""Between two feedbacks."""
DAWDLE_S = 0.5


def choose(random: Random) -> tuple[Work, str]:
    """Return what to ask for next, and which server."""
    if random.random() < 0.05:
        return NOBODY, 'nobody'
    work = random.choice(random.choice((SERVICES, GOALS)))
    server = random.choice((*STEADY, *MORTAL))
    if server in RCLPY and work.ask == FAIL:
        return choose(random)
    if server in MORTAL:
        work = replace(work, timeout=min(work.timeout, PATIENCE_WITH_MORTALS_S))
    return work, server


def is_expected(title: str, server: str, outcome: str, *, may_close: bool) -> bool:
    """Return whether a call may come to this outcome. A server that lives leaves no choice."""
    expected = {ALL[title].outcome}
    if ALL[title].timeout < 1.0:
        expected |= {'NoServerError', ANSWERED}  # before discovery is done; where the caller itself was late
    if server in MORTAL:
        expected |= LOST
        if may_close:
            expected |= CLOSED
    return outcome in expected or outcome == GIVEN_UP
