"""Two clients and a server, and a wire that delivers in any order, under whatever Hypothesis finds.

A client must be told what the server did: every request that arrives is answered once, everybody who
waits for a result is told once, a goal only moves along the table, and its end is one that the server
gave it. In the end no table holds anything but the latest few goals.
"""

from __future__ import annotations

from collections import Counter
from dataclasses import dataclass, field
from functools import partial
from itertools import count
from typing import TYPE_CHECKING, Any

import hypothesis.strategies as st
import pytest
from hypothesis import settings
from hypothesis.stateful import RuleBasedStateMachine, initialize, invariant, precondition, rule

from goalwire.errors import GoalIdTaken, ServerLostError
from goalwire.rules.goals import (
    NO_ID,
    GoalClient,
    GoalEvent,
    GoalPolicy,
    GoalServer,
    GoalStatus,
    decode_status_array,
    preempt,
    queue,
    single,
)
from goalwire.rules.goals.effects import (
    Accepted,
    AskCancel,
    AskGoal,
    DeliverResult,
    Execute,
    FailResult,
    GoalAccepted,
    GoalRejected,
    PublishStatus,
    ReplyCancel,
    ReplyGoal,
    ReplyResult,
    RequestResult,
    StatusChanged,
    UnexpectedReply,
    WakeAt,
)

if TYPE_CHECKING:
    from collections.abc import Callable

    from goalwire.rules.goals.effects import ClientEffect, ServerEffect

pytestmark = pytest.mark.timeout(400)  # a failure takes its time to be shrunk

GONE = ServerLostError('gone')
WHO = st.integers(0, 1)
IDS = st.sampled_from([bytes([n]) * 16 for n in range(1, 5)])
ENDS = st.sampled_from([GoalEvent.SUCCEED, GoalEvent.ABORT, GoalEvent.CANCELED])
INDEX = st.integers(0, 1000)


@dataclass(eq=False)
class Request:
    """One request on its way: its client, and what to do with its reply or without one."""

    client: int
    on_reply: Callable[..., list[ClientEffect[int, bytes]]]
    on_end: Callable[[], list[ClientEffect[int, bytes]]]
    replies: int = 0


@dataclass
class Client:
    """A client's reactor, and what it has been told."""

    reactor: GoalClient[int, bytes] = field(default_factory=GoalClient)
    statuses: dict[bytes, GoalStatus] = field(default_factory=dict)
    waiters: set[int] = field(default_factory=set)
    told: Counter[int] = field(default_factory=Counter)
    alive: bool = True


class World(RuleBasedStateMachine):
    @initialize(policy=st.sampled_from([GoalPolicy(), single(), preempt(), queue(1)]))
    def start(self, policy: GoalPolicy) -> None:
        self.server: GoalServer[Request, bytes] = GoalServer(3, policy, 'abort')
        self.clients = [Client(), Client()]
        self.wire: list[Callable[[], None]] = []
        """The messages under way, which are delivered in any order."""
        self.open: set[Request] = set()
        """Requests that the server has, and has not answered."""
        self.numbers = count()
        self.now = 0
        self.executing: set[bytes] = set()
        self.undecided: list[AskGoal | AskCancel] = []
        self.ends: dict[bytes, set[GoalStatus]] = {}
        """How the server has ended each goal."""

    # ---- the server's side ----

    def serve(self, effects: list[ServerEffect[Request, bytes]]) -> None:
        for effect in effects:
            match effect:
                case AskGoal() | AskCancel():
                    self.undecided.append(effect)
                case Accepted(goal_id):
                    self.executing.discard(goal_id)
                    self.serve(self.server.on_execute(goal_id, self.now))
                case Execute(goal_id):
                    self.executing.add(goal_id)
                case ReplyGoal(request, accepted, _):
                    self.reply(request, accepted)
                case ReplyCancel(request, _, _):
                    self.reply(request)
                case ReplyResult(request, status, result):
                    self.reply(request, status, result or b'')
                case PublishStatus():
                    self.publish()
                case WakeAt(time_ns):
                    assert time_ns > self.now

    def reply(self, request: Request, *answer: Any) -> None:
        request.replies += 1
        assert request in self.open
        self.open.remove(request)
        self.to_client(request.client, lambda: request.on_reply(*answer))

    def publish(self) -> None:
        payload = self.server.take_status()
        if payload is None:
            return
        array = decode_status_array(payload)
        for goal_id, status in array:
            if status.is_terminal:
                self.ends.setdefault(goal_id, set()).add(status)
        for who, client in enumerate(self.clients):
            self.to_client(who, partial(client.reactor.on_status, payload))

    # ---- the clients' side ----

    def to_client(self, who: int, event: Callable[[], list[ClientEffect[int, bytes]]]) -> None:
        """Put something on the wire that only a client that lives will get."""
        self.wire.append(lambda: self.tell(who, event()) if self.clients[who].alive else None)

    def reactor(self, who: int) -> GoalClient[int, bytes]:
        return self.clients[who].reactor

    def tell(self, who: int, effects: list[ClientEffect[int, bytes]]) -> None:
        client = self.clients[who]
        for effect in effects:
            match effect:
                case StatusChanged(goal_id, status) | GoalAccepted(goal_id, status):
                    self.move(client, goal_id, status)
                case DeliverResult(waiter, status, _):
                    client.told[waiter] += 1
                    assert status is GoalStatus.UNKNOWN or status.is_terminal
                case FailResult(waiter, _):
                    client.told[waiter] += 1
                case RequestResult(goal_id):
                    self.request_result(who, goal_id)
                case GoalRejected() | UnexpectedReply():
                    pass

    def move(self, client: Client, goal_id: bytes, status: GoalStatus) -> None:
        before = client.statuses[goal_id]
        assert status >= before
        assert status == before or not before.is_terminal
        client.statuses[goal_id] = status
        if status.is_terminal:
            assert status in self.ends[goal_id]

    def ask(self, request: Request, event: Callable[[Request], list[ServerEffect[Request, bytes]]]) -> None:
        """Put a request on the wire."""

        def arrive() -> None:
            self.open.add(request)
            self.serve(event(request))

        self.wire.append(arrive)

    def request_result(self, who: int, goal_id: bytes) -> None:
        reactor = self.reactor(who)
        request = Request(
            who,
            lambda status, result: reactor.on_result(goal_id, status, result),
            lambda: reactor.on_result_failed(goal_id, GONE),
        )
        self.ask(request, lambda it: self.server.on_result_request(goal_id, it, self.now))

    # ---- what happens ----

    @rule(who=WHO, goal_id=IDS)
    def send(self, who: int, goal_id: bytes) -> None:
        client, reactor = self.clients[who], self.reactor(who)
        if not client.alive:
            return
        try:
            reactor.on_send(goal_id)
        except GoalIdTaken:
            assert reactor.statistics().unanswered + reactor.statistics().active > 0
            return
        client.statuses[goal_id] = GoalStatus.UNKNOWN
        request = Request(
            who,
            lambda accepted: reactor.on_goal_reply(goal_id, accepted),
            lambda: reactor.on_send_failed(goal_id, GONE),
        )
        self.ask(request, lambda it: self.server.on_goal_request(goal_id, it, self.now, bytes([who])))

    @rule(who=WHO, goal_id=IDS)
    def wait_for_result(self, who: int, goal_id: bytes) -> None:
        client = self.clients[who]
        if client.alive and goal_id in client.statuses:
            waiter = next(self.numbers)
            client.waiters.add(waiter)
            self.tell(who, client.reactor.on_result_request(goal_id, waiter))

    @rule(who=WHO, goal_id=st.one_of(IDS, st.just(NO_ID)), stamp=st.integers(0, 2))
    def cancel(self, who: int, goal_id: bytes, stamp: int) -> None:
        request = Request(who, list, list)
        self.ask(request, lambda it: self.server.on_cancel_request(goal_id, stamp, it, self.now))

    @precondition(lambda self: self.wire)
    @rule(at=INDEX)
    def deliver(self, at: int) -> None:
        self.wire.pop(at % len(self.wire))()

    @precondition(lambda self: self.undecided)
    @rule(at=INDEX, yes=st.booleans())
    def decide(self, at: int, yes: bool) -> None:
        question = self.undecided.pop(at % len(self.undecided))
        if isinstance(question, AskGoal):
            self.serve(self.server.on_goal_decision(question.goal_id, yes, self.now))
        else:
            self.serve(self.server.on_cancel_decision(question.cancellation, question.goal_id, yes, self.now))

    @precondition(lambda self: self.executing)
    @rule(at=INDEX, event=ENDS)
    def execute(self, at: int, event: GoalEvent) -> None:
        """A goal's callback ends the goal and returns."""
        goal_id = sorted(self.executing)[at % len(self.executing)]
        self.executing.remove(goal_id)
        status = self.server.status(goal_id)
        if status is GoalStatus.CANCELING or (status.is_active and event is not GoalEvent.CANCELED):
            self.serve(self.server.on_event(goal_id, event, self.now))
        self.serve(self.server.on_result(goal_id, goal_id, self.now))

    @rule(seconds=st.integers(1, 3))
    def pass_time(self, seconds: int) -> None:
        self.now += seconds
        self.serve(self.server.on_time(self.now))

    @precondition(lambda self: next(self.numbers) > 20)
    @rule(who=WHO)
    def kill(self, who: int) -> None:
        """A client dies: who waits there is told by nobody, and the server learns of it."""
        client = self.clients[who]
        if client.alive:
            self.tell(who, client.reactor.on_close(GONE))
            client.alive = False
            self.wire.append(lambda: self.serve(self.server.on_client_lost(bytes([who]), self.now)))

    # ---- what always holds ----

    @invariant()
    def nobody_is_told_twice(self) -> None:
        for client in self.clients:
            assert all(times == 1 for times in client.told.values())

    @invariant()
    def no_more_run_than_may(self) -> None:
        at_once = self.server.policy.at_once
        assert at_once is None or self.server.statistics().running <= at_once

    def teardown(self) -> None:
        """The server goes away while messages are under way; requests that it has not received yet fail."""
        self.serve(self.server.on_close())
        assert not self.open
        while self.wire:
            self.wire.pop()()
            for request in list(self.open):  # it came to a server that was closed already
                self.open.remove(request)
                self.to_client(request.client, request.on_end)
        for client in self.clients:
            held = client.reactor.statistics()
            assert (held.unanswered, held.waiting_for_results) == (0, 0)
            assert set(client.told) == client.waiters
            assert client.alive or held.remembered == 0


TestWorld = World.TestCase
TestWorld.settings = settings(max_examples=100, stateful_step_count=50, deadline=None)
