"""The requests that `top` can send: a call, a goal, a cancellation. The user sees each before it is sent."""

from __future__ import annotations

from collections.abc import Callable
from time import perf_counter
from typing import TYPE_CHECKING, Any, Protocol
from uuid import uuid4

import goalwire
from goalwire.apps.cli.commands.action.cancel import CODES
from goalwire.apps.cli.framework import lookup, values
from goalwire.apps.cli.framework.outcome import CommandError, Outcome
from goalwire.apps.cli.top.data import ServiceLatencies
from goalwire.observe.goal_topics import cancel_request, goal_request, goals_canceling, result_request
from goalwire.observe.goals import status_name
from goalwire.observe.latencies import Latencies

if TYPE_CHECKING:
    from collections.abc import Mapping

Say = Callable[[str], None]
"""Shows a text to the sender of the request."""


class Request(Protocol):
    """Something that can be sent once it has been filled in and confirmed."""

    title: str
    """The request as a phrase that begins a sentence, such as "call /lab/add"."""
    type_name: str

    def template(self) -> str | None:
        """Return the first content of the form, as YAML; None if there is nothing to fill in."""

    def read(self, text: str) -> Any:
        """Return the message that a YAML text describes. Raises CommandError."""

    def show(self, message: Any) -> str:
        """Return the request as it will be sent."""

    async def send(self, message: Any, say: Say) -> None:
        """Send the request and show the outcome. Raises CommandError and goalwire's own errors."""


class _Form:
    """A form in which a message is filled in."""

    def __init__(self, node: goalwire.Node, name: str, type_name: str, part: str) -> None:
        """`part` is the part of the type that is filled in: Request or Goal. Raises CommandError."""
        self._node = node
        self.name = name
        self.type_name = type_name
        self.cls = lookup.interface(type_name)
        self._message_type = getattr(self.cls, part)

    def template(self) -> str | None:
        fields = self._message_type.get_fields_and_field_types()
        return self.show(self._message_type()) if fields else None

    def read(self, text: str) -> Any:
        given: Mapping[str, Any] = values.read_values([text], self._message_type) if text.strip() else {}
        message = self._message_type()
        for set_stamp in values.fill(message, given, self.type_name):
            set_stamp(self._node.clock.now().to_msg())
        return message

    def show(self, message: Any) -> str:
        from rosidl_runtime_py import message_to_yaml

        return message_to_yaml(message).rstrip('\n')


class Call(_Form):
    """A call of a service."""

    def __init__(
        self, node: goalwire.Node, name: str, type_name: str, latencies: ServiceLatencies, timeout: float
    ) -> None:
        super().__init__(node, name, type_name, 'Request')
        self.title = f'call {name}'
        self._timeout = timeout
        self._latencies = latencies.own.setdefault(name, Latencies())

    async def send(self, message: Any, say: Say) -> None:
        client = self._node.client(self.cls, self.name, timeout=self._timeout)
        try:
            await client.wait_for_server(timeout=self._timeout)
            began = perf_counter()
            response = await client.call(message)
            took = perf_counter() - began
        except goalwire.CallError:
            self._latencies.failed += 1
            raise
        finally:
            client.close()
        self._latencies.note(took)
        say(f'{self.name} answered in {took * 1000:.3g} ms:\n{self.show(response)}')


class SendGoal(_Form):
    """A goal. If it still runs when the user leaves `top`, `top` asks whether to cancel it."""

    def __init__(
        self, node: goalwire.Node, name: str, type_name: str, sent: dict[str, str], timeout: float
    ) -> None:
        super().__init__(node, name, type_name, 'Goal')
        self.title = f'send a goal to {name}'
        self._timeout = timeout
        self._sent = sent

    async def send(self, message: Any, say: Say) -> None:
        goal_id = uuid4()
        client = self._node.client(
            self.cls.Impl.SendGoalService, f'{self.name}/_action/send_goal', timeout=self._timeout
        )
        try:
            answer = await client.call(goal_request(self.cls, goal_id.bytes, message))
        finally:
            client.close()
        if not answer.accepted:
            raise CommandError(Outcome.REFUSED, f"'{self.name}' rejects the goal")
        self._sent[goal_id.hex] = self.name
        say(f'{self.name} has accepted the goal {goal_id.hex}')
        try:
            await self._wait(goal_id.hex, say)
        finally:
            del self._sent[goal_id.hex]

    async def _wait(self, goal_id: str, say: Say) -> None:
        client = self._node.client(self.cls.Impl.GetResultService, f'{self.name}/_action/get_result')
        try:
            answer = await client.call(result_request(self.cls, goal_id))
        finally:
            client.close()
        status = status_name(answer.status)
        say(f'the goal {goal_id} of {self.name} has ended: {status}\n{self.show(answer.result)}')


class Cancel:
    """A request to cancel one goal, or all of an action."""

    type_name = 'action_msgs/srv/CancelGoal'

    def __init__(self, node: goalwire.Node, name: str, goal_id: str | None, timeout: float) -> None:
        self._node = node
        self._name = name
        self._goal_id = goal_id
        self._timeout = timeout
        self.title = f'cancel {f"the goal {goal_id}" if goal_id else "ALL goals"} of {name}'

    def template(self) -> str | None:
        return None

    def read(self, _text: str) -> Any:
        return cancel_request(self._goal_id or '')

    def show(self, _message: Any) -> str:
        return f'whoever has sent {"them" if self._goal_id is None else "it"}'

    async def send(self, message: Any, say: Say) -> None:
        from action_msgs.srv import CancelGoal

        client = self._node.client(CancelGoal, f'{self._name}/_action/cancel_goal', timeout=self._timeout)
        try:
            answer = await client.call(message)
        finally:
            client.close()
        if not answer.goals_canceling:
            outcome, problem = CODES.get(
                answer.return_code, (Outcome.NOT_FOUND, 'there is no goal to cancel')
            )
            raise CommandError(outcome, f"'{self._name}': {problem}")
        say('\n'.join(f'canceling the goal {each}' for each in goals_canceling(answer)))
