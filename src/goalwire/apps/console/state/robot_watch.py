"""Watches one live robot: its description, joints and frames; finds robots and navigation targets."""

from __future__ import annotations

import asyncio
import math
from collections.abc import Mapping
from time import monotonic
from typing import TYPE_CHECKING, Any

import goalwire
from goalwire.apps.console.state.robot_model import root_pose
from goalwire.apps.console.state.robot_state import RobotState
from goalwire.errors import peer_text
from goalwire.observe.parameters import NodeParameters
from goalwire.records import record
from goalwire.rules.parameters.parameter import Type
from goalwire.transforms.rigid import IDENTITY, NO_ROTATION, Quaternion, Rigid, multiply, yaw_of

if TYPE_CHECKING:
    from goalwire.apps.console.state.form_model import FormField
    from goalwire.apps.console.state.topics import Reading, Topics

STRING = 'std_msgs/msg/String'
JOINT_STATE = 'sensor_msgs/msg/JointState'
BATTERY = 'sensor_msgs/msg/BatteryState'
TF = 'tf2_msgs/msg/TFMessage'
_PREFIX_S = 5.0
"""Seconds that a node may take to report its frame prefix."""


class RobotWatch(RobotState):
    """The robot of one namespace as it is now, by the topics that the graph shows."""

    def __init__(self, node: goalwire.Node, topics: Topics, namespace: str) -> None:
        super().__init__(namespace)
        self._asking: asyncio.Task[None] | None = None
        self._node = node
        self._topics = topics
        self._readings: dict[str, Reading] = {}

    def look(self) -> None:
        """Subscribe to the topics of the robot that are in the graph now."""
        there = dict(self._node.graph.topics())
        for topic, type_name, listener in (
            (f'{self.namespace}/robot_description', STRING, self._hear_description),
            (f'{self.namespace}/joint_states', JOINT_STATE, self.take_joints),
            (f'{self.namespace}/tf', TF, self.take_frames),
            (f'{self.namespace}/tf_static', TF, self.take_static_frames),
            ('/tf', TF, self.take_frames),
            ('/tf_static', TF, self.take_static_frames),
        ):
            has_publisher = bool(self._node.graph.publishers(topic))
            if topic in self._readings:
                if not has_publisher:
                    self._readings.pop(topic).close()  # a publisher that comes back may offer another QoS
            elif has_publisher and type_name in there.get(topic, ()):
                try:
                    self._readings[topic] = self._topics.read(topic, type_name, listener)
                except goalwire.GoalwireError as error:
                    self.problem = peer_text(error, 300)

    def _hear_description(self, message: Any, at: float) -> None:
        before = self.model
        self.take_description(message, at)
        if self.model is not before:
            self._ask_prefix()

    def _ask_prefix(self) -> None:
        """Ask the publisher of the description for its parameter `frame_prefix`."""
        publishers = self._node.graph.publishers(f'{self.namespace}/robot_description')
        if self._asking is not None:
            self._asking.cancel()
        if len(publishers) == 1:
            loop = asyncio.get_running_loop()
            self._asking = loop.create_task(self._take_prefix(publishers[0].node.qualified))

    async def _take_prefix(self, node: str) -> None:
        self.told_prefix = await _frame_prefix(self._node, node)

    @property
    def is_fresh(self) -> bool:
        """True if a joint state or a frame of the robot came within the last 2 s."""
        return self.age < 2.0

    @property
    def age(self) -> float:
        """The seconds since the last joint state or frame of the robot; infinite if none came."""
        return math.inf if self.moved_at is None else monotonic() - self.moved_at

    def close(self) -> None:
        """Stop watching."""
        if self._asking is not None:
            self._asking.cancel()
        for reading in self._readings.values():
            reading.close()
        self._readings.clear()


def namespaces(topics: list[tuple[str, list[str]]]) -> list[str]:
    """Return the namespaces with a robot: those with a robot_description, or else with joint states."""
    described = [
        name.removesuffix('/robot_description')
        for name, types in topics
        if name.endswith('/robot_description') and STRING in types
    ]
    if described:
        return sorted(described)
    return sorted(
        name.removesuffix('/joint_states')
        for name, types in topics
        if name.endswith('/joint_states') and JOINT_STATE in types
    )


# -- navigation targets --------------------------------------------------------------------------------------


@record
class NavigationTarget:
    """An action whose goal has a target place: a PoseStamped, or numbers x and y."""

    action: str
    type_name: str
    path: tuple[str, ...]
    """The path of the PoseStamped in the goal; () if x and y are fields of the goal itself."""


_PLANNING = {'nav2_msgs/action/ComputePathToPose', 'nav2_msgs/action/ComputePathThroughPoses'}
"""Action types that only plan a path to a place, so that the robot does not move."""


def navigation_target(action: str, type_name: str, fields: tuple[FormField, ...]) -> NavigationTarget | None:
    """Return where an action's goal contains a target place.

    Return None if the goal contains none, or if the action only plans a path.
    """
    if type_name in _PLANNING:
        return None
    for field in fields:
        if field.kind == 'message' and field.base == 'geometry_msgs/msg/PoseStamped':
            return NavigationTarget(action, type_name, (field.name,))
    names = {field.name: field for field in fields}
    if {'x', 'y'} <= names.keys() and all(names[name].kind == 'float' for name in 'xy'):
        return NavigationTarget(action, type_name, ())
    return None


def place_values(
    target: NavigationTarget, values: Mapping[str, Any], frame: str, x: float, y: float, yaw: float
) -> dict[str, Any]:
    """Return a goal's values with the place in them."""
    filled = dict(values)
    if not target.path:
        filled |= {'x': x, 'y': y}
        for name in ('yaw', 'theta', 'heading'):
            if name in filled and isinstance(filled[name], float):
                filled[name] = yaw
        return filled
    filled[target.path[0]] = {
        'header': {'stamp': 'now', 'frame_id': frame},
        'pose': {
            'position': {'x': x, 'y': y, 'z': 0.0},
            'orientation': {'x': 0.0, 'y': 0.0, 'z': math.sin(yaw / 2), 'w': math.cos(yaw / 2)},
        },
    }
    return filled


def find_place(
    target: NavigationTarget, request: Mapping[str, Any], shown: str, frames: Mapping[str, tuple[str, Rigid]]
) -> tuple[float, float, float] | None:
    """Return x, y and yaw of a goal's place in the frame `shown`; None if nothing joins its frame to that.

    A place without a frame counts as given in `shown`. `frames` has each frame's parent, and its pose there.
    """
    if not target.path:
        return float(request['x']), float(request['y']), 0.0
    stamped = request[target.path[0]]
    frame = str(stamped['header']['frame_id']).lstrip('/')
    top, of_frame = root_pose(frame, frames) if frame else (shown, IDENTITY)
    if top != shown:
        return None
    position, turn = stamped['pose']['position'], stamped['pose']['orientation']
    place = of_frame.apply((float(position['x']), float(position['y']), 0.0))
    given: Quaternion = (float(turn['x']), float(turn['y']), float(turn['z']), float(turn['w']))
    return place[0], place[1], yaw_of(multiply(of_frame.rotation, given if any(given) else NO_ROTATION))


async def _frame_prefix(node: goalwire.Node, owner: str) -> str | None:
    """Ask a node for its parameter `frame_prefix`; None if it does not answer or has none."""
    try:
        with NodeParameters(node, owner, _PREFIX_S) as parameters:
            value = (await parameters.values(['frame_prefix'])).get('frame_prefix')
    except goalwire.GoalwireError:
        return None  # A peer may have an invalid name.
    if value is None or value.type != Type.STRING.value:
        return None
    prefix: str = value.string_value.lstrip('/')
    return prefix
