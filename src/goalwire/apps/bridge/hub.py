"""The ROS side of a bridge, which all of its clients share."""

from __future__ import annotations

import asyncio
from collections.abc import Callable, Coroutine
from contextlib import suppress
from typing import Any, Self

import goalwire
from goalwire.apps.bridge.interfaces import Interfaces
from goalwire.apps.bridge.pool import Pool
from goalwire.apps.bridge.settings import Settings
from goalwire.apps.bridge.topic_feeds import Feeds
from goalwire.entities.names import rclpy_exceptions
from goalwire.errors import UnknownInterfaceError
from goalwire.graph.names import NamesAndTypes
from goalwire.rules.names.validation import validate_full_topic_name

_LOOK_S = 1.0
"""Seconds to wait for a name that is not in the graph."""


class Hub:
    """The state that all clients of a bridge share. Use it in an `async with`."""

    def __init__(self, node: goalwire.Node, settings: Settings) -> None:
        self.node = node
        self.settings = settings
        self.feeds = Feeds(node)
        self.interfaces = Interfaces(node)
        self.services: Pool[goalwire.Client[Any, Any]] = Pool()
        self.actions: Pool[goalwire.ActionClient[Any, Any, Any]] = Pool()
        self._tasks: set[asyncio.Task[None]] = set()

    async def __aenter__(self) -> Self:
        self._graph = self.start(self.feeds.follow_graph())
        return self

    async def __aexit__(self, *_error: object) -> None:
        for task in self._tasks:
            task.cancel()
        while self._tasks:
            await asyncio.wait(self._tasks)
        self.feeds.close()
        self.services.close()
        self.actions.close()

    def start(self, work: Coroutine[Any, Any, None]) -> asyncio.Task[None]:
        """Start a task that outlives its client and ends with the bridge."""
        task = asyncio.get_running_loop().create_task(work)
        self._tasks.add(task)
        task.add_done_callback(self._tasks.discard)
        return task

    async def type_of_topic(self, topic: str) -> str:
        """Return the type of a topic. Raises UnknownInterfaceError if the topic has no type, or several."""
        return await self._only_type('topic', topic, self.node.graph.topics)

    async def type_of_service(self, service: str) -> str:
        """Return the type of a service in the graph; raises as `type_of_topic` does."""
        return await self._only_type('service', service, self.node.graph.served)

    async def _only_type(self, what: str, name: str, known: Callable[[], NamesAndTypes]) -> str:
        changes = self.node.graph.changes()
        try:
            with suppress(TimeoutError):
                async with asyncio.timeout(_LOOK_S):
                    while name not in (found := dict(known())):
                        await anext(changes)
        finally:
            changes.close()
        types = found.get(name, [])
        if not types:
            raise UnknownInterfaceError(f"there is no {what} '{name}'")
        if len(types) > 1:
            raise UnknownInterfaceError(f"the {what} '{name}' has several types: {', '.join(types)}")
        return types[0]


def full_name(name: str) -> str:
    """Return the full name, '/a/b' for 'a/b' too; raises InvalidTopicNameException for an invalid name."""
    full = '/' + '/'.join(part for part in name.split('/') if part)
    with rclpy_exceptions():
        validate_full_topic_name(full)
    return full
