"""Real nodes, a server and two clients, driven at random against the table of a goal's states.

One executor, stepped by hand, so that every history is repeatable. After each step both sides must come to
agree with the model: where every goal stands, which results are there, which cancellations were answered how.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

import hypothesis.strategies as st
import pytest
from example_interfaces.action import Fibonacci
from helpers.patience import PATIENCE
from hypothesis import settings
from hypothesis.stateful import RuleBasedStateMachine, precondition, rule, run_state_machine_as_test
from rclpy.action import ActionClient, ActionServer, CancelResponse, GoalResponse
from rclpy.action.client import ClientGoalHandle
from rclpy.action.server import ServerGoalHandle
from rclpy.callback_groups import ReentrantCallbackGroup
from rclpy.context import Context
from rclpy.executors import SingleThreadedExecutor
from rclpy.node import Node
from rclpy.task import Future

from goalwire.execution.time.steady_clock import STEADY
from goalwire.rules.goals.states import TABLE, GoalEvent, GoalStatus

pytestmark = pytest.mark.timeout(400)  # a failure takes its time to be shrunk

INDEX = st.integers(0, 100)
ENDS = st.sampled_from([GoalEvent.SUCCEED, GoalEvent.ABORT, GoalEvent.CANCELED])
METHODS = {GoalEvent.SUCCEED: 'succeed', GoalEvent.ABORT: 'abort', GoalEvent.CANCELED: 'canceled'}
REFUSED = -1


@dataclass(eq=False)
class Goal:
    """One accepted goal: the model's idea of it, and both ends' handles."""

    client: int
    ours: ClientGoalHandle
    server: ServerGoalHandle
    status: GoalStatus = GoalStatus.ACCEPTED
    executed: bool = False
    over: bool = False
    """True once its result is final."""
    gate: Future[None] = field(default_factory=Future)
    results: list[Future[Any]] = field(default_factory=list)


class Nodes(RuleBasedStateMachine):
    def __init__(self) -> None:
        super().__init__()
        self.context = Context()
        self.context.init()
        self.executor = SingleThreadedExecutor(context=self.context)
        node = Node('model', context=self.context)
        self.executor.add_node(node)
        self.goals: list[Goal] = []
        self.accepted: list[ServerGoalHandle] = []
        self.lets_cancel = True
        self.server = ActionServer(
            node,
            Fibonacci,
            'count',
            self.run,
            goal_callback=lambda goal: GoalResponse(2 - (goal.order == REFUSED)),
            handle_accepted_callback=self.accepted.append,
            cancel_callback=lambda _: CancelResponse(1 + self.lets_cancel),
            callback_group=ReentrantCallbackGroup(),
        )
        self.clients = [ActionClient(node, Fibonacci, 'count') for _ in range(2)]
        self.until(lambda: all(client.server_is_ready() for client in self.clients))

    async def run(self, handle: ServerGoalHandle) -> Fibonacci.Result:
        """Execute: wait until a rule says how it ends, and that it is over."""
        await next(goal for goal in self.goals if goal.server is handle).gate
        return Fibonacci.Result(sequence=[handle.request.order])

    def until(self, holds: Any) -> None:
        deadline = STEADY.now() + int(PATIENCE * 1e9)
        while not holds():
            assert STEADY.now() < deadline, 'model and nodes never agreed'
            self.executor.spin_once(timeout_sec=PATIENCE)

    def pick(self, at: int) -> Goal:
        return self.goals[at % len(self.goals)]

    # ---- what happens ----

    @rule(who=st.integers(0, 1), order=st.integers(REFUSED, 3))
    def send(self, who: int, order: int) -> None:
        sent = self.clients[who].send_goal_async(Fibonacci.Goal(order=order))
        self.until(sent.done)
        handle = sent.result()
        assert handle is not None
        assert handle.accepted is (order != REFUSED)
        if handle.accepted:
            self.goals.append(Goal(who, handle, self.accepted.pop()))
        assert self.accepted == []

    @precondition(lambda self: self.goals)
    @rule(at=INDEX)
    def send_an_id_again(self, at: int) -> None:
        """By the other client: its own would refuse to."""
        goal = self.pick(at)
        other = self.clients[1 - goal.client]
        sent = other.send_goal_async(Fibonacci.Goal(order=1), goal_uuid=goal.ours.goal_id)
        self.until(sent.done)
        handle = sent.result()
        assert handle is not None
        assert not handle.accepted

    @precondition(lambda self: self.goals)
    @rule(at=INDEX)
    def execute(self, at: int) -> None:
        goal = self.pick(at)
        if goal.executed or goal.status not in {GoalStatus.ACCEPTED, GoalStatus.CANCELING}:
            return
        goal.server.execute()
        goal.executed = True
        goal.status = TABLE[goal.status].get(GoalEvent.EXECUTE, goal.status)

    @precondition(lambda self: self.goals)
    @rule(at=INDEX, event=ENDS)
    def end(self, at: int, event: GoalEvent) -> None:
        goal = self.pick(at)
        if event in TABLE[goal.status]:
            getattr(goal.server, METHODS[event])()
            goal.status = TABLE[goal.status][event]
            goal.over = goal.over or not goal.executed
        else:
            with pytest.raises(RuntimeError, match='Failed to update goal state'):
                getattr(goal.server, METHODS[event])()

    @precondition(lambda self: self.goals)
    @rule(at=INDEX)
    def return_from_execute(self, at: int) -> None:
        goal = self.pick(at)
        if not goal.executed or goal.over:
            return
        goal.gate.set_result(None)
        goal.over = True
        if not goal.status.is_terminal:
            goal.status = GoalStatus.ABORTED
        self.until(lambda: goal.server.status == goal.status)

    @precondition(lambda self: self.goals)
    @rule(at=INDEX, yes=st.booleans())
    def cancel(self, at: int, yes: bool) -> None:
        goal, self.lets_cancel = self.pick(at), yes
        asked = goal.ours.cancel_goal_async()
        self.until(asked.done)
        answer = asked.result()
        assert answer is not None
        may = GoalEvent.CANCEL_GOAL in TABLE[goal.status]
        assert answer.return_code == (answer.ERROR_NONE if may else answer.ERROR_GOAL_TERMINATED)
        assert len(answer.goals_canceling) == (may and yes)
        if may and yes:
            goal.status = GoalStatus.CANCELING

    @precondition(lambda self: self.goals)
    @rule(who=st.integers(0, 1), yes=st.booleans())
    def cancel_all(self, who: int, yes: bool) -> None:
        self.lets_cancel = yes
        asked = self.clients[who].cancel_all_goals_async()
        self.until(asked.done)
        answer: Any = asked.result()
        meant = [goal for goal in self.goals if GoalEvent.CANCEL_GOAL in TABLE[goal.status]] if yes else []
        canceling = [bytes(info.goal_id.uuid) for info in answer.goals_canceling]
        assert canceling == [bytes(goal.ours.goal_id.uuid) for goal in meant]
        for goal in meant:
            goal.status = GoalStatus.CANCELING

    @precondition(lambda self: self.goals)
    @rule(at=INDEX)
    def ask_for_result(self, at: int) -> None:
        goal = self.pick(at)
        goal.results.append(goal.ours.get_result_async())

    # ---- what both sides must come to ----

    def agrees(self, goal: Goal) -> bool:
        assert all(future.done() <= goal.over for future in goal.results), 'a result before the end'
        told = goal.ours.status
        assert told <= goal.status, 'the client knows more than has happened'
        # ACCEPTED is published along with what comes next
        return (told == goal.status or goal.status is GoalStatus.ACCEPTED) and all(
            future.done() == goal.over for future in goal.results
        )

    @rule()
    def agree(self) -> None:
        self.until(lambda: all(self.agrees(goal) for goal in self.goals))
        for goal in self.goals:
            for future in goal.results:
                response = future.result()
                if response is not None:
                    assert response.status == goal.status

    def teardown(self) -> None:
        try:
            self.agree()
            self.server.destroy()
            for goal in self.goals:
                goal.gate.set_result(None)
            self.until(lambda: all(future.done() for goal in self.goals for future in goal.results))
            for client in self.clients:
                held = client.statistics().goals
                assert (held.unanswered, held.waiting_for_results) == (0, 0)
            self.executor.spin_once(timeout_sec=0.0)
        finally:
            self.executor.shutdown()
            self.context.shutdown()


@pytest.fixture
def transport_name() -> str:
    return 'goalwire_memory'


def test_server_and_clients_agree_with_the_table(isolated: dict[str, str]) -> None:
    run_state_machine_as_test(
        Nodes, settings=settings(max_examples=25, stateful_step_count=30, deadline=None)
    )
