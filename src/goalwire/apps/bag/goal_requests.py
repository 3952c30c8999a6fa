"""Sends a bag's goals to the live action servers, and cancels those that were cancelled in the recording."""

from __future__ import annotations

import asyncio
from collections.abc import Collection
from contextlib import suppress
from typing import Any

from goalwire.aio import ActionClient, Node
from goalwire.aio.action.client import Run
from goalwire.apps.bag.selection import action_of
from goalwire.apps.bag.service_requests import STEPS
from goalwire.errors import CallError, DecodeError
from goalwire.idl import get_action
from goalwire.rosbag2.model import SERVICE_EVENT, Message, Topic
from goalwire.rosbag2.types import decoder_of

_ALL_GOALS = bytes(16)


class GoalRequests:
    """Sends the recorded goals and cancel requests of some actions. Only for the loop's thread.

    Each goal gets a new id, because a server refuses an id that it knows.
    """

    def __init__(self, node: Node, topics: Collection[Topic], source: str) -> None:
        """Make the clients; raises InterfaceError for an action whose type is unknown here."""
        self._node = node
        self._step = STEPS[source]
        self._decoders: dict[str, Any] = {}
        self._clients: dict[str, ActionClient[Any, Any, Any]] = {}
        self._runs: dict[bytes, tuple[str, asyncio.Task[None], Run[Any, Any]]] = {}
        """The goals that were sent, by the ids that they had in the recording."""
        self._cancels: set[asyncio.Task[None]] = set()
        self.sent = 0
        """How many goals were sent."""
        for topic in topics:
            part = topic.name.removesuffix(SERVICE_EVENT).rpartition('/')[2]
            if part not in {'send_goal', 'cancel_goal'}:
                continue
            self._decoders[topic.name] = decoder_of(topic, topics)
            action = action_of(topic.name)
            if part == 'send_goal':
                kind = get_action(topic.type_name.removesuffix('_SendGoal_Event'))
                self._clients[action] = node.action(kind, action)

    def send(self, message: Message) -> None:
        """Send the goal or cancel request in an event.

        Events of the side (server or client) that was not chosen, and events without contents, are ignored.
        """
        decode = self._decoders.get(message.topic)
        if decode is None:
            return  # Of an action's events only goals and cancel requests are sent again.
        try:
            event = decode(message.data)
        except DecodeError as error:
            self._node.logger.warning(f"an event on '{message.topic}' cannot be read: {error}")
            return
        if event.info.event_type != self._step or not event.request:
            return
        request, action = event.request[0], action_of(message.topic)
        if hasattr(request, 'goal_info'):
            self._cancel(action, bytes(request.goal_info.goal_id.uuid))
            return
        run = self._clients[action].send(request.goal)
        task = asyncio.create_task(self._follow(run))
        self._runs[bytes(request.goal_id.uuid)] = action, task, run
        self.sent += 1

    async def _follow(self, run: Run[Any, Any]) -> None:
        try:
            async with run:
                await run.result
        except CallError as error:
            self._node.logger.warning(str(error))

    def _cancel(self, action: str, goal_id: bytes) -> None:
        """Repeat a recorded cancel request: cancel one goal, or all goals of the action."""
        for recorded, (name, task, run) in self._runs.items():
            if name == action and goal_id in {recorded, _ALL_GOALS} and not task.done():
                cancel = asyncio.create_task(self._cancel_run(run))
                self._cancels.add(cancel)
                cancel.add_done_callback(self._cancels.discard)

    async def _cancel_run(self, run: Run[Any, Any]) -> None:
        with suppress(CallError):  # `_follow` reports how the goal ended
            await run.cancel()

    async def finish(self) -> None:
        """Wait for the outstanding results. If the wait is cancelled, the goals are cancelled, too."""
        tasks = [task for _, task, _ in self._runs.values()]
        try:
            await asyncio.gather(*tasks)
        finally:
            for task in tasks:
                task.cancel()

    async def wait_for_servers(self, limit: float) -> None:
        """Wait until all action servers have appeared, or `limit` s have passed."""
        waits = [client.wait_for_server(timeout=limit) for client in self._clients.values()]
        await asyncio.gather(*waits, return_exceptions=True)
