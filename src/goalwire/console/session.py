"""What all browsers share: the node, what it has seen, and what it sends."""

from __future__ import annotations

import asyncio
from contextlib import suppress
from typing import Any, Self

import goalwire
from goalwire.aio.graph import GraphProblem
from goalwire.console.goal_table import GoalTable
from goalwire.console.goal_watch import GoalWatch
from goalwire.console.logs import LogBook
from goalwire.console.robot_model import Meshes
from goalwire.console.robot_watch import (
    BATTERY,
    RobotWatch,
    StopService,
    namespaces,
    stop_services,
)
from goalwire.console.sending import Sender
from goalwire.console.settings import Settings
from goalwire.console.topics import Reading, Topics
from goalwire.errors import UnknownInterfaceError

_TICK_S = 1.0
_STOP_S = 10.0
"""How long an emergency stop may take to answer."""


class Session:
    """`async with` it: it follows goals and logs from the beginning, the rest when a browser asks."""

    def __init__(self, node: goalwire.Node, settings: Settings) -> None:
        self.node = node
        self.settings = settings
        self.topics = Topics(node)
        self.goals = GoalTable()
        self.sender = Sender(node, settings, self.goals)
        self.goal_watch = GoalWatch(node, self.goals, self.sender)
        self.logs = LogBook()
        self.meshes = Meshes()
        self.stops: list[StopService] = []
        self.battery: float | None = None
        """0 to 1."""
        self.battery_at = 0.0
        """When that came: s since 1970."""
        self.battery_topic = ''
        self._robots: dict[str, tuple[RobotWatch, int]] = {}
        self._battery_reading: Reading | None = None
        self._log_reading: Reading | None = None
        self._tasks: list[asyncio.Task[None]] = []

    async def __aenter__(self) -> Self:
        history = goalwire.QoS(depth=1000, durability=goalwire.DurabilityPolicy.TRANSIENT_LOCAL)
        self._log_reading = self.topics.read('/rosout', 'rcl_interfaces/msg/Log', self.logs.take, history)
        self._look()
        loop = asyncio.get_running_loop()
        self._tasks = [loop.create_task(self._follow_graph()), loop.create_task(self._tick())]
        return self

    async def __aexit__(self, *_error: object) -> None:
        for task in self._tasks:
            task.cancel()
        for task in self._tasks:
            with suppress(asyncio.CancelledError):
                await task
        self.sender.close()
        self.goal_watch.close()
        for watch, _ in self._robots.values():
            watch.close()
        self.topics.close()

    async def _follow_graph(self) -> None:
        async for _ in self.node.graph.changes():
            self._look()
            await asyncio.sleep(0.1)  # many changes come together when programs start

    def _look(self) -> None:
        graph = self.node.graph
        self.goal_watch.look()
        self.stops = stop_services(graph.services())
        for watch, _ in self._robots.values():
            watch.look()
        self._look_for_battery(graph.topics())

    def _look_for_battery(self, topics: list[tuple[str, list[str]]]) -> None:
        found = [name for name, types in topics if BATTERY in types and self.node.graph.publishers(name)]
        topic = found[0] if found else ''
        if topic == self.battery_topic:
            return
        if self._battery_reading is not None:
            self._battery_reading.close()
            self._battery_reading, self.battery = None, None
        self.battery_topic = topic
        if topic:
            with suppress(UnknownInterfaceError):
                self._battery_reading = self.topics.read(topic, BATTERY, self._take_battery)

    def _take_battery(self, message: Any, at: float) -> None:
        self.battery_at = at
        self.battery = min(max(float(message.percentage), 0.0), 1.0)

    async def _tick(self) -> None:
        while True:
            await asyncio.sleep(_TICK_S)
            self.topics.measure()

    def problems(self) -> list[GraphProblem]:
        """Return what does not go together, but for what this console itself looks at."""
        own = self.node.name
        found = self.node.graph.problems()
        return [each for each in found if all(end.node.qualified != own for end in each.endpoints)]

    # -- robots ----------------------------------------------------------------------------------------------

    def robot_names(self) -> list[str]:
        """Return the namespaces of the robots that are there."""
        return namespaces(self.node.graph.topics())

    def watch_robot(self, namespace: str) -> RobotWatch:
        """Follow a robot, until `leave_robot` as often."""
        watch, users = self._robots.get(namespace, (None, 0))
        if watch is None:
            watch = RobotWatch(self.node, self.topics, namespace)
            watch.look()
        self._robots[namespace] = (watch, users + 1)
        return watch

    def leave_robot(self, watch: RobotWatch) -> None:
        """One party less follows it."""
        known, users = self._robots[watch.namespace]
        if users > 1:
            self._robots[watch.namespace] = (known, users - 1)
        else:
            del self._robots[watch.namespace]
            watch.close()

    async def emergency_stop(self) -> list[str]:
        """Call every emergency stop there is, all at once; return what each answered. Never asks.

        Raises NotAllowedError where the console is read-only. An allow-list does not hold it up.
        """
        if self.settings.read_only:
            self.settings.check_may_send('')
        return list(await asyncio.gather(*(self._stop(stop) for stop in self.stops)))

    async def _stop(self, stop: StopService) -> str:
        from goalwire.console.types import interface

        cls = interface(stop.type_name)
        try:
            client = self.sender.client(cls, stop.name, stop.type_name)
            answer = await client.call(cls.Request(**stop.values), timeout=_STOP_S)
        except goalwire.GoalwireError as error:
            return f'{stop.name}: {error}'
        if not getattr(answer, 'success', True):
            return f'{stop.name}: refused: {answer.message}'
        return f'{stop.name}: stopped'
