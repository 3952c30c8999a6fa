"""Sends calls, messages, goals and cancel requests of the console, as far as the rights of a visitor allow.

Goals are sent by the three services of an action, not by `Node.action`: a run of `Node.action` ends with its
block, but a goal of the console must outlive the browser, and even the console.
"""

from __future__ import annotations

import asyncio
import os
from collections import deque
from collections.abc import Mapping
from time import monotonic, perf_counter
from typing import Any

import goalwire
from goalwire.apps.console.state.form_model import (
    FormField,
    check,
    defaults_of,
    fill,
    form_of,
    in_one_line,
    without_defaults,
)
from goalwire.apps.console.state.rights import Rights
from goalwire.apps.console.state.snippets import Sending
from goalwire.errors import NotAllowedError, peer_text
from goalwire.observe.goal_topics import cancel_request, goal_request, goals_canceling, result_request
from goalwire.observe.goals import ACTIVE, Goal, GoalTable, status_name
from goalwire.observe.latencies import Latencies
from goalwire.observe.messages import as_data, as_dict, interface_class
from goalwire.records import record
from goalwire.security.policy import Verb

HISTORY = 50
RESULT_S = 10.0
"""Seconds that the result of an ended goal may take to arrive."""
CANCEL_S = 10.0
_PARTS = {'service': 'Request', 'action': 'Goal', 'topic': ''}


@record
class Sent:
    """One message that was sent, and its outcome."""

    at: float
    """The time of sending, by the monotonic clock."""
    sending: Sending
    answer: Mapping[str, Any] | None = None
    problem: str = ''
    seconds: float = 0.0
    who: str = ''
    """The name of the sender; '' if the console knows no names."""


class Target:
    """A service, action or topic that can be sent to, with its form."""

    def __init__(self, kind: str, name: str, type_name: str) -> None:
        """Raises UnknownInterfaceError if the type is not found, or the error of its definition."""
        self.kind = kind
        self.name = name
        self.type_name = type_name
        self.cls = interface_class(type_name)
        part = _PARTS[kind]
        self.message_class = getattr(self.cls, part) if part else self.cls
        self.fields: tuple[FormField, ...] = form_of(f'{type_name}_{part}' if part else type_name)
        self.defaults = defaults_of(self.fields, self.message_class())

    def sending(self, values: Mapping[str, Any], timeout: float | None = None, attempts: int = 1) -> Sending:
        """Return the message to send. Raises FieldValueError if the values do not fit."""
        checked = check(self.fields, values)
        different = without_defaults(checked, as_dict(self.message_class()))
        return Sending(self.kind, self.name, self.type_name, self.fields, different, timeout, attempts)

    def message(self, sending: Sending, now: Any) -> Any:
        """Return the message; `now` is the time that 'now' stands for. Raises FieldValueError."""
        return fill(self.message_class, sending.values, now)


class Sender:
    """Sends calls, messages, goals and cancel requests for all browsers."""

    def __init__(self, node: goalwire.Node, goals: GoalTable) -> None:
        self._node = node
        self._goals = goals
        self._clients: dict[tuple[str, str, goalwire.Retry | None], goalwire.Client[Any, Any]] = {}
        self._publishers: dict[tuple[str, str], goalwire.Publisher[Any]] = {}
        self._tasks: set[asyncio.Task[None]] = set()
        self._awaited: set[tuple[str, str]] = set()
        self.history: dict[tuple[str, str], deque[Sent]] = {}
        """The sent messages by kind and name, the latest last."""
        self.latencies: dict[str, Latencies] = {}
        """The latencies of calls, by service."""

    def target(self, kind: str, name: str, type_name: str) -> Target:
        """Return the target with a name; raises UnknownInterfaceError."""
        return Target(kind, name, type_name)

    def _now(self) -> Any:
        return self._node.clock.now().to_msg()

    def _note(self, sent: Sent) -> Sent:
        key = (sent.sending.kind, sent.sending.name)
        self.history.setdefault(key, deque(maxlen=HISTORY)).append(sent)
        return sent

    # -- services --------------------------------------------------------------------------------------------

    async def call(self, target: Target, sending: Sending, by: Rights) -> Sent:
        """Call a service; the answer includes any failure. Raises NotAllowedError and FieldValueError."""
        request = target.message(sending, self._now())
        by.check_to_send('service', target.name, in_one_line(sending.values))
        client = self.client(target.cls, target.name, target.type_name, sending.retry)
        began, at = perf_counter(), monotonic()
        try:
            response = await client.call(request, timeout=sending.timeout)
        except goalwire.GoalwireError as error:
            return self._note(
                Sent(
                    at,
                    sending,
                    problem=peer_text(_describe(error)),
                    seconds=perf_counter() - began,
                    who=by.who,
                )
            )
        seconds = perf_counter() - began
        self.latencies.setdefault(target.name, Latencies()).note(seconds)
        return self._note(Sent(at, sending, as_data(response), seconds=seconds, who=by.who))

    def client(
        self, cls: Any, name: str, type_name: str, retry: goalwire.Retry | None = None
    ) -> goalwire.Client[Any, Any]:
        """Return the console's client of a service, made when it is first asked for.

        It checks no permission, because reading parameters and results is always allowed.
        """
        key = (name, type_name, retry)
        if key not in self._clients:
            self._clients[key] = self._node.client(cls, name, retry=retry)
        return self._clients[key]

    # -- topics ----------------------------------------------------------------------------------------------

    def publish(self, target: Target, sending: Sending, by: Rights) -> Sent:
        """Publish a message. Raises NotAllowedError, FieldValueError, EncodeError."""
        message = target.message(sending, self._now())
        by.check_to_send('topic', target.name, in_one_line(sending.values))
        self._publisher(target).publish(message)
        return self._note(Sent(monotonic(), sending, who=by.who))

    async def publish_once(self, target: Target, sending: Sending, by: Rights, patience: float = 2.0) -> Sent:
        """Publish when a subscription has been found, or after `patience` s; raises as `publish`."""
        try:
            await self.publisher(target, by).wait_for_subscribers(timeout=patience)
        except goalwire.DeadlineError:
            sent = self.publish(target, sending, by)
            return Sent(sent.at, sent.sending, problem='published, and nobody subscribes to it', who=by.who)
        return self.publish(target, sending, by)

    def publisher(self, target: Target, by: Rights) -> goalwire.Publisher[Any]:
        """Return the console's publisher of a topic; raises NotAllowedError."""
        reason = by.why_not_send('topic', target.name)
        if reason:
            raise NotAllowedError(reason)
        return self._publisher(target)

    def _publisher(self, target: Target) -> goalwire.Publisher[Any]:
        key = (target.name, target.type_name)
        if key not in self._publishers:
            self._publishers[key] = self._node.publisher(target.cls, target.name)
        return self._publishers[key]

    # -- actions ---------------------------------------------------------------------------------------------

    async def send_goal(self, target: Target, sending: Sending, by: Rights) -> Goal:
        """Send a goal and return it after the server has answered; its `problem` says why it was refused.

        With a timeout the goal is cancelled after that time. Raises NotAllowedError, FieldValueError.
        """
        message = target.message(sending, self._now())
        by.check_to_send('action', target.name, in_one_line(sending.values))
        service = target.cls.Impl.SendGoalService
        goal_id = os.urandom(16)
        request = goal_request(target.cls, goal_id, message)
        goal = self._goals.note_sent(target.name, goal_id.hex(), as_data(message), monotonic())
        client = self.client(service, f'{target.name}/_action/send_goal', f'{target.type_name}_SendGoal')
        try:
            answer = await client.call(request, timeout=min(sending.timeout or 10.0, 10.0))
        except goalwire.GoalwireError as error:
            self._goals.end(goal, 'UNKNOWN', peer_text(_describe(error)), monotonic())
            self._note(Sent(monotonic(), sending, problem=goal.problem, who=by.who))
            return goal
        if not answer.accepted:
            self._goals.end(goal, 'ABORTED', 'the server refused the goal', monotonic())
        else:
            goal.move('ACCEPTED', monotonic())
            self._goals.note_change()
            self._in_background(self._await_result(target.cls, target.type_name, goal, sending.timeout))
        self._note(Sent(monotonic(), sending, problem=goal.problem, who=by.who))
        return goal

    async def _await_result(self, cls: Any, type_name: str, goal: Goal, limit: float | None) -> None:
        """Request the result at once, as action clients do; the server answers when the goal has ended."""
        key = (goal.action, goal.goal_id)
        self._awaited.add(key)
        try:
            async with asyncio.timeout(limit):
                await self._take_result(cls, type_name, goal, None)
        except TimeoutError:
            goal.problem = f'it did not end within {limit} s: it is cancelled'
            self._goals.note_change()
            await self.cancel_as_asked(goal.action, goal.goal_id)
            await self._take_result(cls, type_name, goal, RESULT_S)
        finally:
            self._awaited.discard(key)

    async def _take_result(self, cls: Any, type_name: str, goal: Goal, limit: float | None) -> None:
        service = cls.Impl.GetResultService
        request = result_request(cls, goal.goal_id)
        client = self.client(service, f'{goal.action}/_action/get_result', f'{type_name}_GetResult')
        try:
            answer = await client.call(request, timeout=limit)
        except goalwire.GoalwireError as error:
            if goal.is_active:
                self._goals.end(goal, 'UNKNOWN', peer_text(_describe(error)), monotonic())
            return
        status = status_name(answer.status)
        if status != 'UNKNOWN' and status not in ACTIVE:
            goal.result = as_data(answer.result)
            goal.move(status, monotonic())
        elif goal.is_active:
            goal.problem = goal.problem or 'the server does not know the goal any more'
            goal.move('UNKNOWN', monotonic())
        self._goals.note_change()

    def fetch_result(self, type_name: str, goal: Goal) -> None:
        """Request the result of an ended goal, whichever client sent the goal."""
        if goal.result is None and (goal.action, goal.goal_id) not in self._awaited:
            self._in_background(self._take_result(interface_class(type_name), type_name, goal, RESULT_S))

    async def cancel(self, action: str, by: Rights, goal_id: str = '', before: float = 0.0) -> list[str]:
        """Cancel one goal, or the goals accepted up to a time, or all goals; return their ids.

        Raises NotAllowedError, and goalwire's own errors if nobody answers.
        """
        by.check(Verb.CANCEL, action)
        return await self.cancel_as_asked(action, goal_id, before)

    async def cancel_as_asked(self, action: str, goal_id: str = '', before: float = 0.0) -> list[str]:
        """Cancel as `cancel` does, without a check of rights: they were checked when the goal was sent."""
        from action_msgs.srv import CancelGoal

        client = self.client(CancelGoal, f'{action}/_action/cancel_goal', 'action_msgs/srv/CancelGoal')
        answer = await client.call(cancel_request(goal_id, before), timeout=CANCEL_S)
        return goals_canceling(answer)

    # -- background tasks ------------------------------------------------------------------------------------

    def _in_background(self, coroutine: Any) -> None:
        task = asyncio.get_running_loop().create_task(coroutine)
        self._tasks.add(task)
        task.add_done_callback(self._on_end)

    def _on_end(self, task: asyncio.Task[None]) -> None:
        self._tasks.discard(task)
        if not task.cancelled() and (error := task.exception()) is not None:
            self._node.logger.error(f'the console failed: {error!r}')

    def close(self) -> None:
        """Stop waiting for results; the goals go on."""
        for task in self._tasks:
            task.cancel()


def _describe(error: BaseException) -> str:
    return f'{type(error).__name__}: {error}'
