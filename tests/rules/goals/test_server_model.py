"""The server reactor against the table, under whatever order of events Hypothesis finds.

The model performs the effects as a driver would and holds the server to five promises: every request is
answered exactly once, transitions are the table's, every end is published in an array ordered by acceptance,
no more goals run than the policy allows, in the order of their turns, and nothing stays behind.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import hypothesis.strategies as st
import pytest
from hypothesis import settings
from hypothesis.stateful import (
    Bundle,
    RuleBasedStateMachine,
    consumes,
    initialize,
    invariant,
    multiple,
    precondition,
    rule,
)

from goalwire.errors import InvalidTransition
from goalwire.rules.goals import (
    NO_ID,
    TABLE,
    CancelCode,
    GoalEvent,
    GoalPolicy,
    GoalServer,
    GoalStatus,
    OnClientLost,
    decode_status_array,
    parallel,
    preempt,
    queue,
    single,
)
from goalwire.rules.goals.effects import (
    Accepted,
    AskCancel,
    AskGoal,
    Execute,
    PublishStatus,
    ReplyCancel,
    ReplyGoal,
    ReplyResult,
    StoppedByServer,
    WakeAt,
)

if TYPE_CHECKING:
    from collections.abc import Callable

    from goalwire.rules.goals.effects import ServerEffect

pytestmark = pytest.mark.timeout(400)  # a failure takes its time to be shrunk

TIMEOUT = 10
IDS = st.sampled_from([bytes([n]) * 16 for n in range(1, 5)])
CLIENTS = st.sampled_from([b'me', b'you'])
POLICIES = st.sampled_from([GoalPolicy(), parallel(2), single(), preempt(), queue(2)])
ENDS = st.sampled_from([GoalEvent.SUCCEED, GoalEvent.ABORT, GoalEvent.CANCELED])

Effects = list['ServerEffect[int, bytes]']


def reachable(status: GoalStatus) -> set[GoalStatus]:
    """Every status that the table leads to from `status`, itself included."""
    found = {status}
    for later in TABLE.get(status, {}).values():
        found |= reachable(later)
    return found


class ServerMachine(RuleBasedStateMachine):
    questions = Bundle('questions')

    @initialize(
        timeout=st.sampled_from([TIMEOUT, 0, -1]),
        policy=POLICIES,
        lost=st.sampled_from(['keep', 'cancel', 'abort']),
    )
    def start(self, timeout: int, policy: GoalPolicy, lost: OnClientLost) -> None:
        self.server: GoalServer[int, bytes] = GoalServer(timeout, policy, lost)
        self.timeout = timeout
        self.policy = policy
        self.lost = lost
        self.sender: dict[bytes, bytes] = {}
        self.turns: list[bytes] = []
        """Goals that wait, in the order in which they have come."""
        self.now = 0
        self.stamp = 0
        self.requests = 0
        self.answered: dict[int, int] = {}
        self.accepted: list[bytes] = []  # ids in order of acceptance, once for each acceptance
        self.statuses: dict[bytes, GoalStatus] = {}  # of goals that the server should retain
        self.executing: set[bytes] = set()
        self.canceling_told: set[bytes] = set()
        self.published: dict[bytes, GoalStatus] = {}
        self.wake_at: int | None = None
        self.closed = False

    # ---- what a driver does ----

    def request(self) -> int:
        self.requests += 1
        self.answered[self.requests] = 0
        return self.requests

    def perform(self, effects: Effects) -> list[AskGoal | AskCancel]:
        asked: list[AskGoal | AskCancel] = []
        for effect in effects:
            if isinstance(effect, AskGoal | AskCancel):
                asked.append(effect)
            elif isinstance(effect, ReplyGoal | ReplyCancel | ReplyResult):
                self.answered[effect.request] += 1
            if isinstance(effect, ReplyCancel):
                self.judge_cancel(effect)
            elif isinstance(effect, ReplyResult):
                assert effect.status.is_terminal or effect.status is GoalStatus.UNKNOWN
            elif isinstance(effect, PublishStatus):
                self.publish()
            elif isinstance(effect, Execute):
                self.start_executing(effect.goal_id)
            elif isinstance(effect, StoppedByServer):
                assert self.policy.preempts or self.lost != 'keep'
                assert self.server.status(effect.goal_id) in {GoalStatus.CANCELING, GoalStatus.ABORTED}
            elif isinstance(effect, WakeAt):
                assert effect.time_ns > self.now
                self.wake_at = effect.time_ns
        return asked

    def start_executing(self, goal_id: bytes) -> None:
        if goal_id in self.turns:
            assert self.turns.pop(0) == goal_id
        self.executing.add(goal_id)
        assert self.policy.at_once is None or self.server.statistics().running <= self.policy.at_once

    def judge_cancel(self, reply: ReplyCancel[int]) -> None:
        if reply.code is not CancelCode.NONE:
            assert reply.goals == ()
        for goal_id, _ in reply.goals:
            # A status array has told before what this reply promises.
            assert self.published[goal_id] >= GoalStatus.CANCELING

    def publish(self) -> None:
        payload = self.server.take_status()
        if payload is None:
            return
        array = decode_status_array(payload)
        order = [
            max(at for at, known in enumerate(self.accepted) if known == goal_id) for goal_id, _ in array
        ]
        assert order == sorted(order)
        assert len(set(order)) == len(order)
        self.published.update(array)

    def track(self) -> None:
        """Compare the server's goals with the model's: only the table's ways, and only known goals."""
        for goal_id, before in list(self.statuses.items()):
            status = self.server.status(goal_id)
            if status is GoalStatus.UNKNOWN:
                assert self.closed or before.is_terminal or self.timeout == 0
                del self.statuses[goal_id]
            else:
                assert status in reachable(before)
                self.statuses[goal_id] = status
        # A goal that waits for its turn ends there when it is cancelled.
        self.turns = [id_ for id_ in self.turns if self.statuses.get(id_) is GoalStatus.ACCEPTED]

    # ---- what happens ----

    @rule(target=questions, goal_id=IDS, client=CLIENTS)
    def goal_request(self, goal_id: bytes, client: bytes) -> object:
        asked = self.perform(self.server.on_goal_request(goal_id, self.request(), self.now, client))
        if asked:
            self.sender[goal_id] = client
        return multiple(*asked)

    @rule(target=questions, goal_id=st.one_of(IDS, st.just(NO_ID)), back=st.none() | st.integers(0, 3))
    def cancel_request(self, goal_id: bytes, back: int | None) -> object:
        stamp = 0 if back is None else max(self.stamp - back, 0)
        asked = self.perform(self.server.on_cancel_request(goal_id, stamp, self.request(), self.now))
        ids = [question.goal_id for question in asked]
        assert len(set(ids)) == len(ids)
        assert all(self.server.status(id_).is_cancelable for id_ in ids)
        return multiple(*asked)

    @rule(question=consumes(questions), yes=st.booleans(), execute=st.booleans())
    def decide(self, question: AskGoal | AskCancel, yes: bool, execute: bool) -> None:
        if isinstance(question, AskCancel):
            cancellation, goal_id = question.cancellation, question.goal_id
            self.perform(self.server.on_cancel_decision(cancellation, goal_id, yes, self.now))
        else:
            self.decide_goal(question.goal_id, yes, execute)
        self.track()

    def decide_goal(self, goal_id: bytes, yes: bool, execute: bool) -> None:
        self.stamp += 1
        effects = self.server.on_goal_decision(goal_id, yes, self.stamp)
        if any(isinstance(effect, Accepted) for effect in effects):
            assert goal_id not in self.statuses
            self.accepted.append(goal_id)
            self.published.pop(goal_id, None)
            self.executing.discard(goal_id)
            self.statuses[goal_id] = GoalStatus.ACCEPTED
        self.perform(effects)
        if execute:
            self.execute(goal_id)

    @rule(goal_id=IDS)
    def execute(self, goal_id: bytes) -> None:
        running = self.server.statistics().running
        if goal_id in self.turns:
            assert self.server.on_execute(goal_id, self.now) == []
        elif self.policy.at_once is None or running < self.policy.at_once:
            self.attempt(goal_id, GoalEvent.EXECUTE, lambda: self.server.on_execute(goal_id, self.now))
        else:
            self.wait_for_turn(goal_id)

    def wait_for_turn(self, goal_id: bytes) -> None:
        """Every place is taken: a goal that may be executed waits, or ends if it is being cancelled."""
        before = self.server.status(goal_id)
        try:
            effects = self.server.on_execute(goal_id, self.now)
        except InvalidTransition:
            assert before.is_terminal or goal_id in self.executing
            return
        if before is GoalStatus.ACCEPTED:
            self.turns.append(goal_id)
            assert self.server.status(goal_id) is GoalStatus.ACCEPTED
        self.perform(effects)
        self.track()
        if before is GoalStatus.CANCELING:
            assert self.published[goal_id] is GoalStatus.CANCELED
        if self.policy.preempts and before is GoalStatus.ACCEPTED:
            assert self.turns == [goal_id]
            assert not any(self.server.status(id_).is_cancelable for id_ in self.executing - {goal_id})

    @rule(client=CLIENTS)
    def lose_client(self, client: bytes) -> None:
        """A client has gone; what is still being decided for it is refused."""
        asked = self.server.statistics().deciding
        self.perform(self.server.on_client_lost(client, self.now))
        self.track()
        left = [self.server.status(id_) for id_ in self.statuses if self.sender[id_] == client]
        if self.lost == 'keep':
            assert self.server.statistics().deciding == asked
        elif self.lost == 'cancel':
            assert not any(status.is_cancelable for status in left)
        else:
            assert all(status.is_terminal for status in left)

    @rule(goal_id=IDS, event=ENDS)
    def end(self, goal_id: bytes, event: GoalEvent) -> None:
        self.attempt(goal_id, event, lambda: self.server.on_event(goal_id, event, self.now))

    @rule(goal_id=IDS, event=ENDS)
    def finish(self, goal_id: bytes, event: GoalEvent) -> None:
        """End a goal whose execute callback returns at once."""
        server = self.server
        self.attempt(
            goal_id,
            event,
            lambda: [
                *server.on_event(goal_id, event, self.now),
                *server.on_result(goal_id, goal_id, self.now),
            ],
        )

    def attempt(self, goal_id: bytes, event: GoalEvent, act: Callable[[], Effects]) -> None:
        before = self.server.status(goal_id)
        try:
            effects = act()
        except InvalidTransition as refusal:
            assert (refusal.status, refusal.event) == (before, event)  # noqa: PT017 - a model, not a test
            assert event not in TABLE[before]
            return
        after = self.server.status(goal_id)
        if before is GoalStatus.UNKNOWN:
            assert effects == []
        elif effects and effects[0] == PublishStatus():
            assert after in {TABLE[before][event], GoalStatus.UNKNOWN}
        self.perform(effects)
        if before is not GoalStatus.UNKNOWN and event in TABLE[before]:
            assert self.published[goal_id] is TABLE[before][event]
        self.track()

    @rule(goal_id=IDS)
    def return_result(self, goal_id: bytes) -> None:
        if goal_id in self.executing:
            self.executing.remove(goal_id)
            self.perform(self.server.on_result(goal_id, goal_id, self.now))
            assert not self.server.status(goal_id).is_active
            self.track()

    @rule(goal_id=IDS)
    def result_request(self, goal_id: bytes) -> None:
        for effect in self.server.on_result_request(goal_id, self.request(), self.now):
            assert isinstance(effect, ReplyResult)
            assert effect.result in {goal_id, None}
            assert effect.status is self.server.status(goal_id)
            self.perform([effect])

    @rule(seconds=st.integers(1, TIMEOUT))
    def pass_time(self, seconds: int) -> None:
        self.now += seconds
        if self.wake_at is not None and self.wake_at <= self.now:
            self.wake_at = None
            self.perform(self.server.on_time(self.now))
        self.track()

    @precondition(lambda self: self.requests > 12)  # not before there is something to close
    @rule()
    def close(self) -> None:
        self.closed = True
        self.perform(self.server.on_close())
        self.track()
        assert all(count == 1 for count in self.answered.values())

    # ---- what always holds ----

    @invariant()
    def no_request_is_answered_twice(self) -> None:
        assert all(count <= 1 for count in self.answered.values())

    @invariant()
    def every_end_has_been_published(self) -> None:
        assert all(
            self.published[goal_id] is status
            for goal_id, status in self.statuses.items()
            if status.is_terminal
        )

    @invariant()
    def what_expires_has_somebody_to_wake(self) -> None:
        if self.timeout > 0 and not self.closed and self.wake_at is None:
            ended = [status for status in self.statuses.values() if status.is_terminal]
            assert len(ended) <= len(self.executing & self.statuses.keys())

    def teardown(self) -> None:
        if self.closed:
            return
        self.close()
        statistics = self.server.statistics()
        assert (statistics.deciding, statistics.retained, statistics.cancellations) == (0, 0, 0)
        assert self.server.take_status() is None


TestServerMachine = ServerMachine.TestCase
TestServerMachine.settings = settings(max_examples=150, stateful_step_count=40, deadline=None)
