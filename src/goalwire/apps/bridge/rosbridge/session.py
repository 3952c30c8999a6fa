"""One client of rosbridge: reads its operations, and hands each to its handler."""

from __future__ import annotations

from collections.abc import Awaitable, Callable
from typing import Any

from goalwire.apps.bridge.hub import Hub
from goalwire.apps.bridge.outbox import Frame, Outbox
from goalwire.apps.bridge.permissions import Permissions
from goalwire.apps.bridge.rosbridge.client import LEVELS, BadOperationError, Client, Operation, text_of
from goalwire.apps.bridge.rosbridge.encoding import Assembler, BadMessageError, read_frame
from goalwire.apps.bridge.rosbridge.publishing import Publishing
from goalwire.apps.bridge.rosbridge.sent_goals import SendingGoals
from goalwire.apps.bridge.rosbridge.served_actions import ServingActions
from goalwire.apps.bridge.rosbridge.services import Calling, ServingServices
from goalwire.apps.bridge.rosbridge.subscribing import Subscribing
from goalwire.errors import GoalwireError, did_you_mean

Carry = Callable[[Operation], Awaitable[None]]


class RosbridgeSession:
    """One client of the rosbridge protocol; a Session for the server."""

    def __init__(self, hub: Hub, outbox: Outbox, permissions: Permissions) -> None:
        self._client = client = Client(hub, outbox, permissions)
        self._assembler = Assembler(hub.settings.most_bytes)
        self._parts = (
            Publishing(client),
            Subscribing(client),
            Calling(client),
            ServingServices(client),
            SendingGoals(client),
            ServingActions(client),
        )
        self._operations: dict[str, Carry] = {
            'set_level': self._set_level,
            'status': self._ignore,
            'fragment': self._assemble,
            'png': self._assemble,
        }
        for part in self._parts:
            self._operations |= part.operations

    async def receive(self, frame: Frame) -> None:
        """Carry out one operation. A status message tells the client of any error."""
        try:
            operation: dict[str, Any] = read_frame(frame)
        except BadMessageError as error:
            self._client.tell('error', str(error))
            return
        await self._carry_out(operation)

    async def _carry_out(self, operation: Operation) -> None:
        name: str = operation['op']
        carry = self._operations.get(name)
        if carry is None:
            advice = did_you_mean([each for each in self._operations if each.startswith(name[:6])][:3])
            self._client.tell('error', f"there is no operation '{name[:100]}' {advice}".rstrip(), operation)
            return
        try:
            await carry(operation)
        except (GoalwireError, ValueError, TypeError) as error:
            text = str(error)
            self._client.tell('error', text if text.startswith(name) else f'{name}: {text}', operation)

    async def _assemble(self, operation: Operation) -> None:
        inner = self._assembler.add(operation)
        if inner is not None:
            await self._carry_out(inner)

    async def _set_level(self, operation: Operation) -> None:
        level = text_of(operation, 'level')
        if level not in LEVELS:
            raise BadOperationError(f"set_level: 'level' is one of {', '.join(LEVELS)}")
        self._client.level = level

    async def _ignore(self, _operation: Operation) -> None:
        """Ignore status messages of clients."""

    async def close(self) -> None:
        """End the client's calls and subscriptions. Its goals are cancelled, unless the bridge keeps them."""
        for part in self._parts:
            part.close()
        await self._client.end_tasks()
