"""What `top` knows of the robot: rates, latencies, goals, log lines.

It listens only to what is on the screen, so that looking does not load the robot: the rows of one tab. The
log, which is small, is heard all the time.
"""

from __future__ import annotations

import asyncio
from collections import deque
from collections.abc import Awaitable, Callable, Mapping
from contextlib import suppress
from functools import partial
from time import monotonic, time
from typing import TYPE_CHECKING, Any, NamedTuple

import goalwire
from goalwire.apps.cli.commands.action.goals import GoalLine, goal_lines, ran_before, status_subscription
from goalwire.apps.cli.commands.action.progress import Progress, likely_field
from goalwire.apps.cli.framework import lookup
from goalwire.apps.cli.framework.failures import explained
from goalwire.apps.cli.framework.messages import as_dict
from goalwire.apps.cli.framework.outcome import CommandError
from goalwire.apps.cli.framework.output import json_text
from goalwire.rules.qos import suiting
from goalwire.transport.contract import EndpointKind

if TYPE_CHECKING:
    from typing import TypeAlias

    Read: TypeAlias = Callable[[], Awaitable[None]]

WINDOW_S = 5.0
"""Rates are those of the latest seconds."""
HEAVY = 5_000_000
"""Bytes a second beyond which a topic is measured for a moment only, unless it is asked for."""
_MOMENT_S = 1.0
_KEPT = 1000
"""Log lines, latencies, and requests without an answer that are kept at most."""
_REPAINT_S = 0.2
_LEVELS = {10: 'DEBUG', 20: 'INFO', 30: 'WARN', 40: 'ERROR', 50: 'FATAL'}


class Readers:
    """Tasks that each read something while it is wanted, by a key."""

    def __init__(self) -> None:
        self._tasks: dict[str, asyncio.Task[None]] = {}
        self.problems: dict[str, str] = {}
        """Why something cannot be read, in one line."""

    def want(self, wanted: Mapping[str, Read]) -> None:
        """Read these, and nothing else. What has ended is not begun again before it was not wanted once."""
        for key in self._tasks.keys() - wanted.keys():
            self._tasks.pop(key).cancel()
            self.problems.pop(key, None)
        for key in wanted.keys() - self._tasks.keys():
            self._tasks[key] = asyncio.create_task(self._run(key, wanted[key]))

    def again(self, key: str) -> None:
        """Begin this one anew where it is wanted the next time."""
        if (task := self._tasks.pop(key, None)) is not None:
            task.cancel()

    async def _run(self, key: str, read: Read) -> None:
        try:
            await read()
        except Exception as error:
            self.problems[key] = explained(error)[1]

    async def close(self) -> None:
        """Read nothing any more."""
        tasks = list(self._tasks.values())
        self.want({})
        await asyncio.gather(*tasks, return_exceptions=True)


class Rate:
    """How often something came within the latest seconds, and how much of it."""

    def __init__(self) -> None:
        self._came: deque[tuple[float, int]] = deque(maxlen=100_000)
        self._bytes = 0
        self._since = monotonic()
        self.is_paused = False
        """Whether it is too much to be measured all the time; the figures are then those of a moment."""

    def note(self, now: float, size: int) -> None:
        """Something has come."""
        if len(self._came) == self._came.maxlen:
            self._bytes -= self._came[0][1]
        self._came.append((now, size))
        self._bytes += size

    def figures(self, now: float) -> tuple[float, float] | None:
        """Return messages and bytes a second; None while it cannot be said."""
        while not self.is_paused and self._came and self._came[0][0] < now - WINDOW_S:
            self._bytes -= self._came.popleft()[1]
        n = len(self._came)
        if not n:
            return (0.0, 0.0) if now - self._since >= WINDOW_S else None
        lasted = self._came[-1][0] - self._came[0][0]
        if n == 1 or lasted <= 0:
            return (n / WINDOW_S, self._bytes / WINDOW_S) if now - self._since >= WINDOW_S else None
        return (n - 1) / lasted, self._bytes * (n - 1) / n / lasted

    def is_heavy(self, now: float) -> bool:
        """Return whether it has been too much for a moment."""
        return self._bytes > HEAVY * max(_MOMENT_S, now - self._since)


class TopicRates:
    """Rates of the topics that are on the screen. Best effort: publishers do not wait for us."""

    def __init__(self, node: goalwire.Node) -> None:
        self._node = node
        self.readers = Readers()
        self.rates: dict[str, Rate] = {}
        self._asked: set[str] = set()

    def watch(self, topics: Mapping[str, str]) -> None:
        """Measure these topics, given with their types, and no others."""
        for name in self.rates.keys() - topics.keys():
            if not self.rates[name].is_paused:
                del self.rates[name]
        self.readers.want({name: partial(self._measure, name, kind) for name, kind in topics.items()})

    def ask(self, name: str) -> None:
        """Measure a topic however much comes."""
        self._asked.add(name)
        self.rates.pop(name, None)

    async def _measure(self, name: str, type_name: str) -> None:
        while True:
            if (paused := self.rates.get(name)) is not None and paused.is_paused:
                return
            rate = self.rates[name] = Rate()
            subscription = self._node.subscription(
                lookup.interface(type_name),
                name,
                qos=goalwire.QoS(depth=1000, reliability=goalwire.ReliabilityPolicy.BEST_EFFORT),
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


class Latencies:
    """How long answers took."""

    def __init__(self) -> None:
        self.seconds: deque[float] = deque(maxlen=_KEPT)
        self.number = 0
        self.failed = 0

    def note(self, seconds: float) -> None:
        """An answer has come."""
        self.seconds.append(seconds)
        self.number += 1


class Steps:
    """The steps of a service's calls, as its clients and its server publish them."""

    SENT, RECEIVED, ANSWERED, CAME = range(4)

    def __init__(self) -> None:
        self.client = Latencies()
        """From the request to the response, where clients publish both."""
        self.server = Latencies()
        """From the request's coming to the response's going, at the server."""
        self._begun: dict[tuple[bytes, int, int], float] = {}

    def note(self, info: Any) -> None:
        """Take a service_msgs/msg/ServiceEventInfo."""
        call = bytes(info.client_gid), int(info.sequence_number)
        when = info.stamp.sec + info.stamp.nanosec / 1e9
        if info.event_type in {self.SENT, self.RECEIVED}:
            self._begun[(*call, info.event_type)] = when
            while len(self._begun) > _KEPT:
                del self._begun[next(iter(self._begun))]
            return
        is_client = info.event_type == self.CAME
        begun = self._begun.pop((*call, self.SENT if is_client else self.RECEIVED), None)
        if begun is not None:
            (self.client if is_client else self.server).note(max(0.0, when - begun))


class ServiceLatencies:
    """Latencies of the calls that are made here, and of others' where introspection is on."""

    def __init__(self, node: goalwire.Node) -> None:
        self._node = node
        self.readers = Readers()
        self.own: dict[str, Latencies] = {}
        self.steps: dict[str, Steps] = {}

    def watch(self, services: Mapping[str, str]) -> None:
        """Hear the events of these services, given with their types, and of no others."""
        self.readers.want({name: partial(self._hear, name, kind) for name, kind in services.items()})

    async def _hear(self, name: str, type_name: str) -> None:
        steps = self.steps.setdefault(name, Steps())
        subscription = self._node.subscription(
            lookup.interface(type_name).Event, f'{name}/_service_event', qos=1000
        )
        try:
            async for event in subscription:
                steps.note(event.info)
        finally:
            subscription.close()

    def best(self, name: str) -> tuple[str, Latencies] | None:
        """Return latencies and whose they are: 'clients', 'server' or 'top'; None where there are none."""
        steps = self.steps.get(name)
        found = [('clients', steps.client), ('server', steps.server)] if steps is not None else []
        if name in self.own:
            found.append(('top', self.own[name]))
        return next((each for each in found if each[1].number or each[1].failed), None)


class ActionGoals:
    """The goals of one action."""

    def __init__(self) -> None:
        self.goals: dict[str, GoalLine] = {}
        self.feedback: dict[str, Any] = {}
        self.done: dict[str, float] = {}
        self._progress: dict[tuple[str, str], Progress] = {}
        self._began = time()
        self._ran_before: set[str] | None = None
        """The goals of which the first feedback was missed; None before the first status."""

    def take_status(self, array: Any) -> None:
        """Take an action_msgs/msg/GoalStatusArray."""
        self.goals = {goal.goal_id: goal for goal in goal_lines(array)}
        if self._ran_before is None:
            self._ran_before = ran_before(self.goals.values(), self._began)
        for goal_id in self.feedback.keys() - self.goals.keys():
            del self.feedback[goal_id]
            self.done.pop(goal_id, None)
        self._progress = {key: reader for key, reader in self._progress.items() if key[0] in self.goals}

    def take_feedback(self, message: Any, spec: str | None) -> None:
        """Take a feedback message; `spec` is its field of progress, as in `--progress`."""
        goal_id = bytes(message.goal_id.uuid).hex()
        self.feedback[goal_id] = message.feedback
        for field in (spec, likely_field(message.feedback)):
            if field is not None:
                with suppress(CommandError):  # another action's field
                    saw_start = goal_id not in (self._ran_before or ())
                    reader = self._progress.setdefault((goal_id, field), Progress(field, saw_start=saw_start))
                    done = reader.of(message.feedback)
                    if done is not None:
                        self.done[goal_id] = done
                    return


class Goals:
    """The goals of the actions that are on the screen."""

    def __init__(self, node: goalwire.Node, progress: str | None = None) -> None:
        self._node = node
        self._progress = progress
        self.readers = Readers()
        self.actions: dict[str, ActionGoals] = {}

    def watch(self, actions: Mapping[str, str]) -> None:
        """Follow the goals of these actions, given with their types, and of no others."""
        self.readers.want({name: partial(self._follow, name, kind) for name, kind in actions.items()})

    async def _follow(self, name: str, type_name: str) -> None:
        goals = self.actions[name] = ActionGoals()
        status = status_subscription(self._node, name)
        try:
            feedback = self._node.subscription(
                lookup.interface(type_name).Impl.FeedbackMessage, f'{name}/_action/feedback', qos=100
            )
            try:
                async with asyncio.TaskGroup() as group:
                    group.create_task(self._read_status(status, goals))
                    group.create_task(self._read_feedback(feedback, goals))
            finally:
                feedback.close()
        finally:
            status.close()

    async def _read_status(self, status: goalwire.Subscription[Any], goals: ActionGoals) -> None:
        async for array in status:
            goals.take_status(array)

    async def _read_feedback(self, feedback: goalwire.Subscription[Any], goals: ActionGoals) -> None:
        async for message in feedback:
            goals.take_feedback(message, self._progress)


class LogLine(NamedTuple):
    """A line of /rosout."""

    time: float
    level: str
    name: str
    text: str


class Log:
    """The latest lines of /rosout."""

    def __init__(self, node: goalwire.Node) -> None:
        self._node = node
        self.lines: deque[LogLine] = deque(maxlen=_KEPT)
        self.number = 0
        """How many lines have come."""
        self.readers = Readers()
        self.readers.want({'/rosout': self._read})

    async def _read(self) -> None:
        from rcl_interfaces.msg import Log as LogMessage

        subscription = self._node.subscription(LogMessage, '/rosout', qos=_KEPT)
        try:
            async for message in subscription:
                level = _LEVELS.get(message.level, str(message.level))
                when = message.stamp.sec + message.stamp.nanosec / 1e9
                self.lines.append(LogLine(when, level, message.name, message.msg))
                self.number += 1
        finally:
            subscription.close()


class Echo:
    """The latest message of one topic. Only what can be shown is decoded."""

    def __init__(self, node: goalwire.Node, show: Callable[[str], None]) -> None:
        self._node = node
        self._show = show
        self.readers = Readers()

    def follow(self, name: str, type_name: str) -> None:
        """Show the messages of a topic from now on."""
        self.readers.want({})
        self.readers.want({name: partial(self._read, name, type_name)})

    def stop(self) -> None:
        """Show nothing any more."""
        self.readers.want({})

    async def _read(self, name: str, type_name: str) -> None:
        from rosidl_runtime_py import message_to_yaml

        publishers = self._node.context.graph.entities(EndpointKind.PUBLISHER, name)
        try:
            subscription = self._node.subscription(
                lookup.interface(type_name), name, qos=suiting([publisher.qos for publisher in publishers], 1)
            )
            try:
                async for message in subscription:
                    self._show(message_to_yaml(message, truncate_length=128))
                    await asyncio.sleep(_REPAINT_S)
            finally:
                subscription.close()
        except Exception as error:
            self._show(explained(error)[1])


def one_line(message: Any) -> str:
    """Return a message on one line."""
    return json_text(as_dict(message))
