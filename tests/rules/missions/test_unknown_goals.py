"""A goal that its server does not have: is it certain that it never ran? Held against a model of servers."""

from __future__ import annotations

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from goalwire.rules.goals.server_snapshot import ServerSnapshot, hash_of_statuses
from goalwire.rules.missions.unknown_goals import NEWCOMER_S, Whereabouts, judge

A = ServerSnapshot(frozenset({'a'}), 'x')


@pytest.mark.parametrize(
    ('sent', 'now', 'listened', 'age', 'expected'),
    [
        (A, A, 0.0, None, Whereabouts.NEVER_ARRIVED),
        (A, ServerSnapshot(A.servers, 'y'), 9.0, 9.0, Whereabouts.NEVER_ARRIVED),
        (A, ServerSnapshot(A.servers, 'y'), 9.0, 11.0, Whereabouts.LOST),
        (A, ServerSnapshot(A.servers, 'y'), 9.0, None, Whereabouts.LOST),
        (A, ServerSnapshot(frozenset({'b'}), 'x'), 9.0, 1.0, Whereabouts.LOST),
        (None, A, 9.0, 1.0, Whereabouts.LOST),
        (ServerSnapshot(A.servers, ''), ServerSnapshot(A.servers, ''), 2.0, 60.0, Whereabouts.TOO_EARLY),
        (ServerSnapshot(A.servers, ''), ServerSnapshot(A.servers, ''), 6.0, 60.0, Whereabouts.NEVER_ARRIVED),
        (A, ServerSnapshot(A.servers, ''), 2.0, 60.0, Whereabouts.TOO_EARLY),
        (A, ServerSnapshot(A.servers, ''), 6.0, 60.0, Whereabouts.LOST),
    ],
)
def test_judging(
    sent: ServerSnapshot | None,
    now: ServerSnapshot,
    listened: float,
    age: float | None,
    expected: Whereabouts,
) -> None:
    where, why = judge(sent, now, listened=listened, age=age)
    assert where is expected
    assert why


def test_a_status_array_without_goals_has_no_hash() -> None:
    assert hash_of_statuses(b'') == hash_of_statuses(bytes.fromhex('00010000' + '00000000')) == ''
    assert len(hash_of_statuses(bytes.fromhex('00010000' + '01000000') + bytes(40))) == 16


class Server:
    """A server as rcl's rules have it: it keeps results for a time, and tells of changes, not of expiry."""

    def __init__(self, keeps: float) -> None:
        self.keeps = keeps
        self.incarnation = 0
        self.now = 0.0
        self.goals: dict[int, float | None] = {}
        self.array: tuple[tuple[int, bool], ...] = ()
        self.ran: list[int] = []

    def wait(self, seconds: float) -> None:
        self.now += seconds
        for goal, ended in list(self.goals.items()):
            if ended is not None and self.now - ended >= self.keeps:
                del self.goals[goal]

    def take(self, goal: int, lasts: float) -> None:
        """Execute a goal to its end."""
        self.ran.append(goal)
        self.goals[goal] = None
        self._publish()
        self.wait(lasts)
        self.goals[goal] = self.now
        self._publish()

    def restart(self) -> None:
        self.incarnation += 1
        self.goals, self.array = {}, ()

    def _publish(self) -> None:
        self.array = tuple((goal, ended is not None) for goal, ended in sorted(self.goals.items()))

    def view(self, has_heard: bool) -> ServerSnapshot:
        statuses = repr(self.array) if self.array and has_heard else ''
        return ServerSnapshot(frozenset({str(self.incarnation)}), statuses)


OURS = 0
Event = tuple[str, float]
EVENTS = st.lists(
    st.tuples(st.sampled_from(['wait', 'other', 'arrive', 'restart', 'reboot']), st.floats(0.0, 40.0)),
    max_size=8,
)


def play(before: list[Event], after: list[Event], keeps: float, heard: bool, listened: float) -> str:
    """Send a goal between two lists of events, lose the answer, and judge. Returns what the rule says."""
    server = Server(keeps)
    others = iter(range(1, 100))
    for what, seconds in before:
        if what == 'other':
            server.take(next(others), seconds)
        elif what == 'restart':
            server.restart()
        server.wait(seconds)
    sent, sent_at, is_same_boot = server.view(heard), server.now, True
    has_arrived = False
    for what, seconds in after:
        if what == 'other':
            server.take(next(others), seconds)
        elif what == 'arrive' and not has_arrived:
            has_arrived = True
            server.take(OURS, seconds)
        elif what == 'restart':
            server.restart()
        elif what == 'reboot':
            is_same_boot = False
        else:
            server.wait(seconds)
    if OURS in server.goals:
        return 'the server tells'
    age = server.now - sent_at if is_same_boot else None
    hears_now = listened >= NEWCOMER_S or heard
    where, _ = judge(sent, server.view(hears_now), listened=listened, age=age, kept=10.0)
    if where is Whereabouts.NEVER_ARRIVED:
        assert OURS not in server.ran, 'a goal that ran would be sent again'
    return where.value


HISTORIES = given(EVENTS, EVENTS, st.sampled_from([10.0, 15.0, 900.0]), st.booleans(), st.floats(0.0, 10.0))


@settings(max_examples=300)
@HISTORIES
def test_no_goal_that_ran_counts_as_one_that_never_arrived(
    before: list[Event], after: list[Event], keeps: float, heard: bool, listened: float
) -> None:
    play(before, after, keeps, heard, listened)


@pytest.mark.long
@pytest.mark.timeout(3600)
@settings(max_examples=100_000)
@HISTORIES
def test_none_does_in_a_hundred_thousand_histories(
    before: list[Event], after: list[Event], keeps: float, heard: bool, listened: float
) -> None:
    play(before, after, keeps, heard, listened)
