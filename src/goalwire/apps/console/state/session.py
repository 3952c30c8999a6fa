"""Shared by all browsers: the node, its observations, and its requests."""

from __future__ import annotations

import asyncio
from collections import Counter
from collections.abc import Callable, Iterable
from contextlib import suppress
from itertools import count
from typing import Self

import goalwire
from goalwire.aio.graph import GraphProblem
from goalwire.apps.console.settings import Settings
from goalwire.apps.console.state.goal_watch import GoalWatch
from goalwire.apps.console.state.live_recording import LiveRecording
from goalwire.apps.console.state.meshes import Meshes
from goalwire.apps.console.state.mission_journal import MissionJournal
from goalwire.apps.console.state.ownership import may_move
from goalwire.apps.console.state.presses import Press, Presses
from goalwire.apps.console.state.rights import Rights
from goalwire.apps.console.state.robot_watch import RobotWatch, namespaces
from goalwire.apps.console.state.sending import Sender
from goalwire.apps.console.state.stopping import Answer, Listener, release, stop
from goalwire.apps.console.state.teleop import Teleops
from goalwire.apps.console.state.topics import Topics
from goalwire.apps.console.state.type_watch import TypeWatch
from goalwire.apps.console.state.vitals import Vitals
from goalwire.observe.goals import GoalTable
from goalwire.observe.log import LogBook
from goalwire.security.sign_in.authorizer import Authorizer, Principal
from goalwire.security.sign_in.signed_in import SignedIn

_TICK_S = 0.2
_TICKS_OF_RATES = 5


class Session:
    """The state that all pages share.

    In its `async with` block it follows goals and logs. It follows other data only when a browser needs it.
    """

    def __init__(self, node: goalwire.Node, settings: Settings, authorizer: Authorizer | None = None) -> None:
        self.node = node
        self.settings = settings
        self._authorizer = authorizer
        self.topics = Topics(node)
        self.types = TypeWatch(node, self._look)
        self.goals = GoalTable()
        self.sender = Sender(node, self.goals)
        self.goal_watch = GoalWatch(node, self.goals, self.sender, self.types)
        self.logs = LogBook()
        self.recording = LiveRecording(node, settings)
        self.missions = MissionJournal(settings.missions) if settings.missions else None
        """The journal of missions; None if the console shows none."""
        self.meshes = Meshes()
        self.vitals: dict[str, Vitals] = {}
        """By namespace: the vitals of present robots, and of gone ones that a page has selected.

        If there are none, '' stands for everything on the wire.
        """
        self.listeners: set[Callable[[], object]] = set()
        """Functions that are called when the shown state of an emergency stop has changed."""
        self.presses = Presses(self.stop)
        self.teleops = Teleops()
        self._robots: dict[str, tuple[RobotWatch, int]] = {}
        self._selected: Counter[str] = Counter()
        self._tasks: list[asyncio.Task[None]] = []

    async def __aenter__(self) -> Self:
        history = goalwire.QoS(depth=1000, durability=goalwire.DurabilityPolicy.TRANSIENT_LOCAL)
        self.topics.read('/rosout', 'rcl_interfaces/msg/Log', self.logs.take, history)
        self._look()
        loop = asyncio.get_running_loop()
        self._tasks = [loop.create_task(self._follow_graph()), loop.create_task(self._tick())]
        return self

    async def __aexit__(self, *_error: object) -> None:
        self.teleops.stop()
        for task in self._tasks:
            task.cancel()
        for task in self._tasks:
            with suppress(asyncio.CancelledError):
                await task
        await self.presses.close()
        await self.recording.stop()
        self.types.close()
        self.sender.close()
        self.goal_watch.close()
        for watch, _ in self._robots.values():
            watch.close()
        for vitals in self.vitals.values():
            vitals.close()
        self.topics.close()

    async def _follow_graph(self) -> None:
        async for _ in self.node.graph.changes():
            self._look()
            await asyncio.sleep(0.1)  # A starting program causes many changes at once.

    def _look(self) -> None:
        self.types.look()
        self.goal_watch.look()
        for watch, _ in self._robots.values():
            watch.look()
        self._look_at_robots()

    def _look_at_robots(self) -> None:
        there = self.robot_names()
        gone = {name for name in self._selected if name in self.vitals and self.vitals[name].was_there}
        wanted = {*there, *gone} or {''}
        for name in self.vitals.keys() - wanted:
            self.vitals.pop(name).close()
        for name in sorted(wanted):
            if name not in self.vitals:
                self.vitals[name] = Vitals(self.node, self.topics, name, self._tell)
            self.vitals[name].was_there |= name in there
            self.vitals[name].look(wanted)
        self._tell()

    def _tell(self) -> None:
        for listener in list(self.listeners):
            listener()

    async def _tick(self) -> None:
        for tick in count(1):
            await asyncio.sleep(_TICK_S)
            for vitals in self.vitals.values():
                vitals.tick()
            if tick % _TICKS_OF_RATES == 0:
                await self.topics.measure()

    def problems(self) -> list[GraphProblem]:
        """Return the mismatches in the graph, without those of this console's own endpoints."""
        own = self.node.name
        found = self.node.graph.problems()
        return [each for each in found if all(end.node.qualified != own for end in each.endpoints)]

    # -- robots ----------------------------------------------------------------------------------------------

    def robot_names(self) -> list[str]:
        """Return the namespaces of the present robots."""
        graph = self.node.graph
        return namespaces([(name, types) for name, types in graph.topics() if graph.publishers(name)])

    def select(self, namespace: str) -> None:
        """Watch a robot's vitals, even after it has gone, until `deselect` was called once for each call."""
        self._selected[namespace] += 1
        self._look_at_robots()

    def may_move(self, name: str, robot: str) -> bool:
        """Return whether a message to that name can move only this robot."""
        return may_move(name, robot, self.vitals)

    def deselect(self, namespace: str) -> None:
        """Note that one page fewer has the robot selected."""
        self._selected[namespace] -= 1
        if not self._selected[namespace]:
            del self._selected[namespace]
        self._look_at_robots()

    def watch_robot(self, namespace: str) -> RobotWatch:
        """Follow a robot until `leave_robot` was called once for each call."""
        watch, users = self._robots.get(namespace, (None, 0))
        if watch is None:
            watch = RobotWatch(self.node, self.topics, namespace)
            watch.look()
        self._robots[namespace] = (watch, users + 1)
        return watch

    def leave_robot(self, watch: RobotWatch) -> None:
        """Note that one page fewer follows the robot."""
        known, users = self._robots[watch.namespace]
        if users > 1:
            self._robots[watch.namespace] = (known, users - 1)
        else:
            del self._robots[watch.namespace]
            watch.close()

    # -- people ----------------------------------------------------------------------------------------------

    def rights_of(self, principal: Principal | None) -> Rights:
        """Return what a visitor may do; None stands for everybody on a console where nobody signs in."""
        visitor = None
        if self._authorizer is not None and principal is not None:
            visitor = SignedIn(self._authorizer, principal)
        return Rights(self.settings, self.node.logger, visitor)

    # -- stopping --------------------------------------------------------------------------------------------

    def begin_stop(self, press: str, robot: str, by: Rights, *, is_for_all: bool) -> Press:
        """Return the press of STOP of that id; the first call with an id stops the robot, or all robots."""
        self.teleops.stop('STOP was pressed: let the pad go.')
        return self.presses.begin(press, sorted(self.vitals) if is_for_all else [robot], by)

    async def stop(self, robots: Iterable[str], tell: Listener, by: Rights) -> None:
        """Call every emergency stop of robots, all at once, without a question, and report each answer.

        Raises NotAllowedError if the console is read-only, or the policy says that the visitor may not stop.
        The allow-list does not apply.
        """
        stopped = []
        for name in robots:
            if name in self.vitals:
                stopped.append(self.vitals[name])
            else:
                tell(Answer(name, '', 'this console does not see the robot', is_done=False))
        by.check_to_stop([service.name for each in stopped for service in each.emergency.known])
        await stop(self.node, stopped, tell)

    def why_not_release(self, robot: str, by: Rights) -> str:
        """Return why a visitor may not release a robot, which lets it move; '' if it may."""
        services = self.vitals[robot].emergency.can_release
        return next(filter(None, (by.why_not_send('service', each.name) for each in services)), '')

    async def release(self, robot: str, by: Rights) -> list[Answer]:
        """Call the services that release a robot, and return the answers. Raises NotAllowedError."""
        for service in self.vitals[robot].emergency.can_release:
            by.check_to_send('service', service.name, 'release')
            by.note('release', service.name, 'the emergency stop is released')
        return await release(self.node, self.vitals[robot])
