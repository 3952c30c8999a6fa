"""The state of a robot of a fleet, as the robot reports it: its battery, its emergency stop, and its goals.

Everything is read from topics that many robots have: sensor_msgs/BatteryState, the states of emergency stops,
and the status of each action. Nothing is asked of the robot, and nothing on it changes.
"""

from __future__ import annotations

import asyncio
from contextlib import suppress
from typing import TYPE_CHECKING, Any

from goalwire.errors import GoalwireError
from goalwire.observe.emergency_stops import says_state, word_of
from goalwire.observe.goal_topics import fetch_known_goals
from goalwire.observe.messages import interface_class
from goalwire.records import record
from goalwire.rules.names.robots import robot_of
from goalwire.rules.qos import suiting

if TYPE_CHECKING:
    from goalwire.aio import Node, Subscription

BATTERY = 'sensor_msgs/msg/BatteryState'


@record
class RobotState:
    """One robot of a fleet, at the moment of the question."""

    robot: str
    nodes: int
    """How many nodes the robot has."""
    stopped: bool | None
    """True if the robot's emergency stop is pressed; None if the robot does not say."""
    battery: float | None
    """The battery's charge, from 0 to 1; None if the robot did not say in time."""
    goals: int
    """How many of the robot's goals wait or run."""

    @property
    def word(self) -> str:
        """The state in one word: 'stopped', 'busy' or 'idle'."""
        return 'stopped' if self.stopped else 'busy' if self.goals else 'idle'


async def look_at(node: Node, robot: str, patience: float) -> RobotState:
    """Return a robot's state. Each topic may take `patience` s to send its latest message."""
    nodes = sum(robot_of(name.rpartition('/')[0]) == robot for name in node.graph.nodes())
    topics = [(name, types) for name, types in node.graph.topics() if name.startswith(f'/{robot}/')]
    actions = [name for name, _ in node.graph.served_actions() if name.startswith(f'/{robot}/')]
    battery, stopped, goals = await asyncio.gather(
        _battery(node, [name for name, types in topics if BATTERY in types], patience),
        _is_stopped(node, topics, patience),
        asyncio.gather(*(_active_goals(node, action, patience) for action in actions)),
    )
    return RobotState(robot, nodes, stopped, battery, sum(goals))


async def _battery(node: Node, topics: list[str], patience: float) -> float | None:
    for topic in topics:
        message = await _latest(node, topic, BATTERY, patience)
        if message is not None and message.percentage == message.percentage:
            return float(message.percentage)
    return None


async def _is_stopped(node: Node, topics: list[tuple[str, list[str]]], patience: float) -> bool | None:
    """Return whether a robot is stopped; if its topics disagree, it is."""
    found = [(topic, each) for topic, types in topics for each in types if says_state(topic, each)]
    told = await asyncio.gather(*(_latest(node, topic, each, patience) for topic, each in found))
    words = [
        word_of(message, '', topic, is_switch=False).stopped
        for (topic, _), message in zip(found, told, strict=True)
        if message is not None
    ]
    return any(words) if words else None


async def _active_goals(node: Node, action: str, patience: float) -> int:
    return sum(goal.is_active for goal in await fetch_known_goals(node, action, patience))


async def _latest(node: Node, topic: str, type_name: str, patience: float) -> Any:
    """Return the next message of a topic, which may be a kept one; None if none comes within `patience` s."""
    publishers = node.graph.publishers(topic)
    if not publishers:
        return None
    with suppress(GoalwireError, TimeoutError):  # a peer may have announced a topic of any name or type
        qos = suiting([each.qos for each in publishers], 1)
        subscription: Subscription[Any] = node.subscription(interface_class(type_name), topic, qos=qos)
        try:
            async with asyncio.timeout(patience):
                return await anext(subscription)
        finally:
            subscription.close()
    return None
