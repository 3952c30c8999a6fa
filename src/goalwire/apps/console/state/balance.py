"""A robot that can fall: the topic that says so, and the services that put it up and push it.

The names and types are those of the humanoid's simulation: `fallen` (std_msgs/Bool), `get_up`
(std_srvs/Trigger) and `push` (a type Push with a force in N along the world's axes, and a duration in s).
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

import goalwire
from goalwire.apps.console.state.topics import Reading, Topics
from goalwire.errors import peer_text
from goalwire.records import record
from goalwire.transforms.rigid import Rigid, yaw_of

_BOOL = 'std_msgs/msg/Bool'
_TRIGGER = 'std_srvs/srv/Trigger'
_PUSH = '/srv/Push'
PUSH_S = 0.2


@record
class Service:
    """A service of the robot."""

    name: str
    type_name: str


class Balance:
    """Whether one robot lies on the floor, and what the console can do about it."""

    def __init__(self, node: goalwire.Node, topics: Topics) -> None:
        self.get_up: Service | None = None
        self.push: Service | None = None
        self.problem = ''
        self._node = node
        self._topics = topics
        self._topic = ''
        self._reading: Reading | None = None

    @property
    def is_told(self) -> bool:
        """True if the robot says whether it lies on the floor."""
        return self._reading is not None

    @property
    def has_fallen(self) -> bool | None:
        """True if the robot lies on the floor; None until the robot has reported it."""
        latest = None if self._reading is None else self._reading.reader.latest
        return None if latest is None else bool(latest.data)

    def look(self, robot: str) -> None:
        """Find the topic and the services of a robot in the graph."""
        graph = self._node.graph
        topic = f'{robot}/fallen'
        is_there = bool(graph.publishers(topic)) and (topic, [_BOOL]) in graph.topics()
        if not is_there or topic != self._topic:
            self.close()
        if is_there and self._reading is None:
            self._topic = topic
            try:
                self._reading = self._topics.read(topic, _BOOL)
            except goalwire.GoalwireError as error:
                self.problem = peer_text(error, 300)
        served = {name: types[0] for name, types in graph.served() if name.startswith(f'{robot}/')}
        self.get_up = _service(f'{robot}/get_up', served, _TRIGGER)
        self.push = _service(f'{robot}/push', served, _PUSH)

    def close(self) -> None:
        """End the subscription."""
        if self._reading is not None:
            self._reading.close()
        self._reading, self._topic, self.problem = None, '', ''


def _service(name: str, served: Mapping[str, str], ending: str) -> Service | None:
    type_name = served.get(name, '')
    return Service(name, type_name) if type_name.endswith(ending) else None


def push_values(newtons: float, degrees: float, base: Rigid) -> dict[str, Any]:
    """Return the request of a push by `newtons`.

    `degrees` is its direction, counted to the left from where the robot faces. `base` is the pose of the
    robot's root link in the world.
    """
    way = yaw_of(base.rotation) + math.radians(degrees)
    x, y = (round(newtons * part, 3) + 0.0 for part in (math.cos(way), math.sin(way)))
    force = {'x': x, 'y': y, 'z': 0.0}
    return {'force': force, 'duration': PUSH_S}
