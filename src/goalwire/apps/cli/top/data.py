"""The figures that `top` shows of the robot: rates, latencies, goals, log lines.

To save the robot's resources, it subscribes only for the rows of one tab that are on the screen. The log is
small, so it is received all the time.
"""

from __future__ import annotations

import asyncio
from collections.abc import Awaitable, Callable, Mapping
from functools import partial
from time import monotonic
from typing import TYPE_CHECKING, Any

import goalwire
from goalwire.apps.cli.framework.failures import explain_error
from goalwire.apps.cli.framework.output import json_text
from goalwire.observe.described_types import class_in_use
from goalwire.observe.goal_topics import follow_goals
from goalwire.observe.goals import GoalTable
from goalwire.observe.latencies import Latencies
from goalwire.observe.log import LogBook
from goalwire.observe.messages import as_dict
from goalwire.observe.rates import Pace, Rate
from goalwire.observe.serialized_types import find_serialized_type
from goalwire.observe.service_calls import POSTFIX, ServiceCalls
from goalwire.rules.qos import suiting
from goalwire.transport.contract import EndpointKind

if TYPE_CHECKING:
    from typing import TypeAlias

    Read: TypeAlias = Callable[[], Awaitable[None]]

HEAVY = 5_000_000
"""Bytes a second above which a topic is measured only for a moment, unless the user asks for more."""
_MOMENT_S = 1.0
_DEPTH = 1000
_REPAINT_S = 0.2


class Readers:
    """Tasks by keys. Each task reads one thing, such as a topic's rate, while the screen needs it."""

    def __init__(self) -> None:
        self._tasks: dict[str, asyncio.Task[None]] = {}
        self.problems: dict[str, str] = {}
        """By key, in one line: why a task has failed."""

    def want(self, wanted: Mapping[str, Read]) -> None:
        """Run exactly these tasks. An ended task starts anew only after a call of `want` without its key."""
        for key in self._tasks.keys() - wanted.keys():
            self._tasks.pop(key).cancel()
            self.problems.pop(key, None)
        for key in wanted.keys() - self._tasks.keys():
            self._tasks[key] = asyncio.create_task(self._run(key, wanted[key]))

    def again(self, key: str) -> None:
        """Cancel the task with this key, so that the next `want` starts it anew."""
        if (task := self._tasks.pop(key, None)) is not None:
            task.cancel()

    async def _run(self, key: str, read: Read) -> None:
        try:
            await read()
        except Exception as error:
            self.problems[key] = explain_error(error)[1]

    async def close(self) -> None:
        """Stop reading."""
        tasks = list(self._tasks.values())
        self.want({})
        await asyncio.gather(*tasks, return_exceptions=True)


class TopicRate:
    """The rate of one topic, in messages and bytes a second."""

    def __init__(self) -> None:
        self._rate = Rate()
        self._since = monotonic()
        self._count = self._bytes = 0
        self.is_paused = False
        """True if the topic is too fast to be measured all the time; its figures are from one moment."""

    def note(self, now: float, size: int) -> None:
        """Count a message."""
        self._count += 1
        self._bytes += size
        self._rate.note(self._count, now, self._bytes)

    def pace(self, now: float) -> Pace | None:
        """Return messages and bytes a second; None until enough messages were measured."""
        return self._rate.latest() if self.is_paused else self._rate.pace(now)

    def is_heavy(self, now: float) -> bool:
        """Return True if the topic's messages have brought more than HEAVY bytes a second."""
        return self._bytes > HEAVY * max(_MOMENT_S, now - self._since)


class TopicRates:
    """Rates of the topics that are on the screen, by best-effort subscriptions, so publishers never wait."""

    def __init__(self, node: goalwire.Node) -> None:
        self._node = node
        self.readers = Readers()
        self.rates: dict[str, TopicRate] = {}
        self._asked: set[str] = set()

    def watch(self, topics: Mapping[str, str]) -> None:
        """Measure these topics, given with their types, and no others."""
        for name in self.rates.keys() - topics.keys():
            if not self.rates[name].is_paused:
                del self.rates[name]
        self.readers.want({name: partial(self._measure, name, kind) for name, kind in topics.items()})

    def ask(self, name: str) -> None:
        """Measure a topic even if its data rate is high."""
        self._asked.add(name)
        self.rates.pop(name, None)

    async def _measure(self, name: str, type_name: str) -> None:
        while True:
            if (paused := self.rates.get(name)) is not None and paused.is_paused:
                return
            rate = self.rates[name] = TopicRate()
            subscription = self._node.subscription(
                find_serialized_type(self._node.context.graph, name, type_name),
                name,
                qos=goalwire.QoS(depth=_DEPTH, reliability=goalwire.ReliabilityPolicy.BEST_EFFORT),
                raw=True,
            )
            try:
                async for message in subscription:
                    now = monotonic()
                    rate.note(now, len(message))
                    if name not in self._asked and rate.is_heavy(now):
                        rate.is_paused = True
                        return
            finally:
                subscription.close()


class ServiceLatencies:
    """Latencies of the calls of `top`, and of other clients' calls if service introspection is on."""

    def __init__(self, node: goalwire.Node) -> None:
        self._node = node
        self.readers = Readers()
        self.own: dict[str, Latencies] = {}
        self.calls: dict[str, ServiceCalls] = {}

    def watch(self, services: Mapping[str, str]) -> None:
        """Hear the events of these services, given with their types, and of no others."""
        self.readers.want({name: partial(self._hear, name, kind) for name, kind in services.items()})

    async def _hear(self, name: str, type_name: str) -> None:
        calls = self.calls.setdefault(name, ServiceCalls())
        cls = await class_in_use(self._node, type_name)
        subscription = self._node.subscription(cls.Event, name + POSTFIX, qos=_DEPTH)
        try:
            async for event in subscription:
                calls.take(event)
        finally:
            subscription.close()

    def best(self, name: str) -> tuple[str, Latencies] | None:
        """Return latencies and who measured them: 'clients', 'server' or 'top'; None if there are none."""
        calls = self.calls.get(name)
        found = [('clients', calls.clients), ('server', calls.server)] if calls is not None else []
        if name in self.own:
            found.append(('top', self.own[name]))
        return next((each for each in found if each[1].number or each[1].failed), None)


class Goals:
    """The goals of the actions that are on the screen."""

    def __init__(self, node: goalwire.Node, progress: str | None = None) -> None:
        self._node = node
        self.readers = Readers()
        self.table = GoalTable(progress)

    def watch(self, actions: Mapping[str, str]) -> None:
        """Follow the goals of these actions, given with their types, and of no others."""
        self.readers.want({name: partial(self._follow, name, kind) for name, kind in actions.items()})

    async def _follow(self, name: str, type_name: str) -> None:
        self.table.forget(name)
        await follow_goals(self._node, name, await class_in_use(self._node, type_name), self.table)


class Log:
    """The latest lines of /rosout."""

    def __init__(self, node: goalwire.Node) -> None:
        self._node = node
        self.book = LogBook()
        self.readers = Readers()
        self.readers.want({'/rosout': self._read})

    async def _read(self) -> None:
        from rcl_interfaces.msg import Log as LogMessage

        subscription = self._node.subscription(LogMessage, '/rosout', qos=_DEPTH)
        try:
            async for message in subscription:
                self.book.take(message)
        finally:
            subscription.close()


class Echo:
    """The latest message of one topic. Only messages that are shown are decoded."""

    def __init__(self, node: goalwire.Node, show: Callable[[str], None]) -> None:
        self._node = node
        self._show = show
        self.readers = Readers()

    def follow(self, name: str, type_name: str) -> None:
        """Show the messages of a topic from now on."""
        self.readers.want({})
        self.readers.want({name: partial(self._read, name, type_name)})

    def stop(self) -> None:
        """Stop showing messages."""
        self.readers.want({})

    async def _read(self, name: str, type_name: str) -> None:
        from rosidl_runtime_py import message_to_yaml

        publishers = self._node.context.graph.entities(EndpointKind.PUBLISHER, name)
        try:
            cls = await class_in_use(self._node, type_name)
            subscription = self._node.subscription(
                cls, name, qos=suiting([publisher.qos for publisher in publishers], 1)
            )
            try:
                async for message in subscription:
                    self._show(message_to_yaml(message, truncate_length=128))
                    await asyncio.sleep(_REPAINT_S)
            finally:
                subscription.close()
        except Exception as error:
            self._show(explain_error(error)[1])


def one_line(message: Any) -> str:
    """Return a message on one line."""
    return json_text(as_dict(message))
