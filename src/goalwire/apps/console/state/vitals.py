"""A robot's battery and emergency stop, which every view shows to the operator."""

from __future__ import annotations

import asyncio
from collections.abc import Callable, Collection
from contextlib import suppress
from typing import Any

import goalwire
from goalwire.apps.console.state.emergency import EmergencyState, Standing
from goalwire.apps.console.state.ownership import may_move, may_stop
from goalwire.apps.console.state.robot_watch import BATTERY
from goalwire.apps.console.state.topics import Reading, Topics
from goalwire.observe.emergency_stops import says_state, stop_services, word_of
from goalwire.observe.messages import interface_class
from goalwire.rules.qos import suiting


class StateReader:
    """Listens to one topic on which a robot reports the state of its emergency stop."""

    def __init__(self, node: goalwire.Node, topic: str, type_name: str, hear: Callable[..., object]) -> None:
        """`hear(publisher, message, topic)` is called with each message. Raises UnknownInterfaceError."""
        self.topic = topic
        self.qos = _qos(node, topic)
        self._hear = hear
        self._subscription: goalwire.Subscription[Any] = node.subscription(
            interface_class(type_name), topic, qos=self.qos
        )
        self._task = asyncio.get_running_loop().create_task(self._follow())

    async def _follow(self) -> None:
        async for message in self._subscription:
            info = self._subscription.info
            publisher = info['publisher_gid']['data'] if info is not None else b''
            self._hear(publisher, message, self.topic)

    def close(self) -> None:
        """Stop listening."""
        self._task.cancel()
        self._subscription.close()


class Vitals:
    """The battery and the emergency stop of the robot in one namespace."""

    def __init__(
        self, node: goalwire.Node, topics: Topics, namespace: str, changed: Callable[[], object]
    ) -> None:
        """`changed` is called when the emergency stop's state or its possible actions have changed."""
        self.namespace = namespace
        self.was_there = False
        """True once a robot of this namespace was in the graph.

        It stays False for a namespace '' that stands for everything on the wire.
        """
        self.emergency = EmergencyState()
        self.battery: float | None = None
        """The charge of the battery, from 0 to 1; None if it is unknown."""
        self.battery_at = 0.0
        """The time at which the battery's charge was received, by the monotonic clock."""
        self._node = node
        self._topics = topics
        self._changed = changed
        self._waiting: set[asyncio.Event] = set()
        self._battery_topic = ''
        self._battery_reading: Reading | None = None
        self._readers: dict[str, StateReader] = {}
        self._told: object = None

    def look(self, robots: Collection[str]) -> None:
        """Update subscriptions and services from the graph; `robots` are the robots in it."""
        graph = self._node.graph
        served = stop_services(graph.served())
        self.emergency.serve([each for each in served if may_stop(each.name, self.namespace, robots)])
        topics = [each for each in graph.topics() if may_stop(each[0], self.namespace, robots)]
        self._look_for_states(topics)
        self._look_for_battery([each for each in topics if may_move(each[0], self.namespace, robots)])
        self._tell()

    def tick(self) -> None:
        """Count for how long the robot is silent. Must be called every 0.2 s."""
        self.emergency.look()
        self._tell()

    # -- the emergency stop ----------------------------------------------------------------------------------

    def _look_for_states(self, topics: list[tuple[str, list[str]]]) -> None:
        graph = self._node.graph
        there = {
            topic: {publisher.gid for publisher in graph.publishers(topic)}
            for topic, types in topics
            if any(says_state(topic, each) for each in types)
        }
        self.emergency.keep({(topic, gid) for topic, gids in there.items() for gid in gids})
        for topic in list(self._readers):
            if not there.get(topic) or self._readers[topic].qos != _qos(self._node, topic):
                self._readers.pop(topic).close()  # New publishers may offer another QoS.
        for topic, types in topics:
            if there.get(topic) and topic not in self._readers:
                kind = next(each for each in types if says_state(topic, each))
                with suppress(goalwire.GoalwireError):  # a peer may announce a topic of any name or type
                    self._readers[topic] = StateReader(self._node, topic, kind, self._hear)

    def _hear(self, publisher: bytes, message: Any, topic: str) -> None:
        graph = self._node.graph
        found = [each for each in graph.publishers(topic) if each.gid == publisher]
        node = found[0].node.qualified if found else 'an unknown node'
        switches = {end.node.qualified for each in self.emergency.servers for end in graph.servers(each.name)}
        self.emergency.hear(publisher, word_of(message, node, topic, is_switch=node in switches))
        self._tell()

    def _tell(self) -> None:
        emergency = self.emergency
        state = (emergency.standing, emergency.reason, emergency.by, emergency.servers)
        if state == self._told:
            return
        self._told = state
        for event in self._waiting:
            event.set()
        self._changed()

    async def says_stopped(self, patience: float) -> bool:
        """Wait until the robot stops reporting "not stopped", `patience` s at most; else return False.

        A robot whose state is unknown, or that publishes no state, counts as stopped.
        """
        event = asyncio.Event()
        self._waiting.add(event)
        try:
            async with asyncio.timeout(max(patience, 0.0)):
                while self.emergency.standing is Standing.RELEASED:
                    event.clear()
                    await event.wait()
        except TimeoutError:
            return False
        finally:
            self._waiting.discard(event)
        return True

    # -- the battery -----------------------------------------------------------------------------------------

    def _look_for_battery(self, topics: list[tuple[str, list[str]]]) -> None:
        found = [name for name, types in topics if BATTERY in types and self._node.graph.publishers(name)]
        topic = found[0] if found else ''
        if topic == self._battery_topic:
            return
        if self._battery_reading is not None:
            self._battery_reading.close()
            self._battery_reading, self.battery = None, None
        self._battery_topic = topic
        if topic:
            with suppress(goalwire.GoalwireError):  # a peer may announce a topic of any name or type
                self._battery_reading = self._topics.read(topic, BATTERY, self._take_battery)

    def _take_battery(self, message: Any, at: float) -> None:
        self.battery_at = at
        self.battery = min(max(float(message.percentage), 0.0), 1.0)

    def close(self) -> None:
        """Stop watching."""
        if self._battery_reading is not None:
            self._battery_reading.close()
        for reader in self._readers.values():
            reader.close()
        self._readers.clear()


def _qos(node: goalwire.Node, topic: str) -> goalwire.QoS:
    return suiting([publisher.qos for publisher in node.graph.publishers(topic)], 10)
