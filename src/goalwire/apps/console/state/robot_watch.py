"""One robot as it is now: its description, joints, frames, battery, and the services that stop it."""

from __future__ import annotations

import asyncio
import math
from collections import deque
from collections.abc import Mapping
from time import monotonic
from typing import TYPE_CHECKING, Any

import goalwire
from goalwire.apps.console.state.robot_model import RobotModel, likely_prefix, read_urdf, root_pose
from goalwire.errors import RemoteError, peer_text
from goalwire.observe.parameters import NodeParameters
from goalwire.records import record
from goalwire.rules.parameters.parameter import Type
from goalwire.transforms.rigid import Rigid

if TYPE_CHECKING:
    from goalwire.apps.console.state.form_model import FormField
    from goalwire.apps.console.state.topics import Reading, Topics

STRING = 'std_msgs/msg/String'
JOINT_STATE = 'sensor_msgs/msg/JointState'
BATTERY = 'sensor_msgs/msg/BatteryState'
TF = 'tf2_msgs/msg/TFMessage'
_PREFIX_S = 5.0
"""How long a node may take to tell its frame prefix."""
_TRAIL = 600
_TRAIL_STEP = 0.03
_MOST_FRAMES = 2000


class RobotWatch:
    """The robot of one namespace: '' where topics have the plain names /robot_description, /joint_states."""

    def __init__(self, node: goalwire.Node, topics: Topics, namespace: str) -> None:
        self.namespace = namespace
        self.model: RobotModel | None = None
        self.problem = ''
        self.version = 0
        """Another one with each new description."""
        self.positions: dict[str, float] = {}
        self.frames: dict[str, tuple[str, Rigid]] = {}
        """By child frame: its parent, and its pose in it."""
        self.trail: deque[tuple[float, float, float]] = deque(maxlen=_TRAIL)
        self.moved_at: float | None = None
        """When it moved, or said that it stands, by the monotonic clock."""
        self._links: frozenset[str] = frozenset()
        self._told_prefix: str | None = None
        self._prefix: str | None = None
        self._asking: asyncio.Task[None] | None = None
        self._node = node
        self._topics = topics
        self._readings: dict[str, Reading] = {}

    def look(self) -> None:
        """Subscribe to what the graph has by now."""
        there = dict(self._node.graph.topics())
        for topic, type_name, listener in (
            (f'{self.namespace}/robot_description', STRING, self._take_description),
            (f'{self.namespace}/joint_states', JOINT_STATE, self._take_joints),
            (f'{self.namespace}/tf', TF, self._take_frames),
            (f'{self.namespace}/tf_static', TF, self._take_static_frames),
            ('/tf', TF, self._take_frames),
            ('/tf_static', TF, self._take_static_frames),
        ):
            has_publisher = bool(self._node.graph.publishers(topic))
            if topic in self._readings:
                if not has_publisher:
                    self._readings.pop(topic).close()  # one that comes back may offer another QoS
            elif has_publisher and type_name in there.get(topic, ()):
                try:
                    self._readings[topic] = self._topics.read(topic, type_name, listener)
                except goalwire.GoalwireError as error:
                    self.problem = peer_text(error, 300)

    def _take_description(self, message: Any, _at: float) -> None:
        try:
            self.model = read_urdf(message.data)
            self._links = frozenset(self.model.kinematics.links)
            self.problem = ''
        except RemoteError as error:
            kept = '' if self.model is None else 'A new description was not taken, the one before is shown: '
            self.problem = f'{kept}{peer_text(error, 300)}'
            self.version += 1
            return
        self.version += 1
        self._prefix = None
        if self._node is not None:
            self._ask_prefix()

    def _ask_prefix(self) -> None:
        """Ask who publishes the description for its parameter `frame_prefix`."""
        publishers = self._node.graph.publishers(f'{self.namespace}/robot_description')
        if self._asking is not None:
            self._asking.cancel()
        if len(publishers) == 1:
            loop = asyncio.get_running_loop()
            self._asking = loop.create_task(self._take_prefix(publishers[0].node.qualified))

    async def _take_prefix(self, node: str) -> None:
        self._told_prefix = await _frame_prefix(self._node, node)

    @property
    def prefix(self) -> str:
        """The text before the names of its links in the names of their frames."""
        if self._told_prefix is not None:
            return self._told_prefix
        if self._prefix is None and self.model is not None:
            self._prefix = likely_prefix(self.model, self.frames, self.namespace)
        return self._prefix or ''

    def _take_joints(self, message: Any, at: float) -> None:
        for name, position in zip(message.name, message.position, strict=False):
            if math.isfinite(position):
                self.positions[name] = position
        self.moved_at = at

    def _take_frames(self, message: Any, at: float) -> None:
        children = self._keep_frames(message)
        if self.model is None or any(map(self._is_own, children)):
            self.moved_at = at  # robots share /tf: the frames of another one do not make this one live
        if self.model is not None and self.prefix + self.model.kinematics.root in self.frames:
            self._lengthen_trail(self.pose()[1])

    def _take_static_frames(self, message: Any, _at: float) -> None:
        """They come to each new subscriber, though the robot may have gone since they were published."""
        self._keep_frames(message)

    def _keep_frames(self, message: Any) -> list[str]:
        """Note the frames of a message, and return those whose transforms make sense."""
        kept = []
        for each in message.transforms:
            t, r = each.transform.translation, each.transform.rotation
            numbers = (t.x, t.y, t.z, r.x, r.y, r.z, r.w)
            length = math.hypot(*numbers[3:])
            if not all(map(math.isfinite, numbers)) or length < 1e-6 or len(self.frames) >= _MOST_FRAMES:
                continue
            turn = (r.x / length, r.y / length, r.z / length, r.w / length)
            child, parent = each.child_frame_id.lstrip('/'), each.header.frame_id.lstrip('/')
            if child not in self.frames:
                self._prefix = None
            self.frames[child] = (parent, Rigid((t.x, t.y, t.z), turn))
            kept.append(child)
        return kept

    def _is_own(self, frame: str) -> bool:
        """Return whether a frame is one of its links'."""
        prefix = self.prefix
        return frame.startswith(prefix) and frame[len(prefix) :] in self._links

    def pose(self) -> tuple[str, Rigid]:
        """Return the frame that everything is shown in, and the robot's pose there."""
        return root_pose(
            self.prefix + self.model.kinematics.root if self.model is not None else '', self.frames
        )

    def _lengthen_trail(self, pose: Rigid) -> None:
        x, y, z = pose.translation
        if not self.trail or math.dist(self.trail[-1][:2], (x, y)) > _TRAIL_STEP:
            self.trail.append((x, y, z))

    def link_poses(self) -> list[tuple[str, list[float]]]:
        """Return each link's pose in the shown frame: x, y, z and the quaternion x, y, z, w."""
        _, base = self.pose()
        if self.model is None:
            return []
        poses = self.model.kinematics.poses(self.positions, self.frames, self.prefix)
        found = []
        for link in self.model.kinematics.links:
            motion = base.after(poses[link])
            numbers = [round(number, 5) for number in (*motion.translation, *motion.rotation)]
            found.append((link, numbers))
        return found

    @property
    def is_fresh(self) -> bool:
        """Whether it has moved, or said that it stands, within 2 s."""
        return self.age < 2.0

    @property
    def age(self) -> float:
        """How long ago it moved, or said that it stands, in s; infinite if it never did."""
        return math.inf if self.moved_at is None else monotonic() - self.moved_at

    def close(self) -> None:
        """Watch no more."""
        if self._asking is not None:
            self._asking.cancel()
        for reading in self._readings.values():
            reading.close()
        self._readings.clear()


def namespaces(topics: list[tuple[str, list[str]]]) -> list[str]:
    """Return the namespaces that have a robot: a robot_description, or else joint states."""
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


# -- where it may be sent ------------------------------------------------------------------------------------


@record
class NavigationTarget:
    """An action whose goal has a place for where to go: a PoseStamped, or numbers x and y."""

    action: str
    type_name: str
    path: tuple[str, ...]
    """To the PoseStamped; () if x and y are the goal's own."""


def navigation_target(action: str, type_name: str, fields: tuple[FormField, ...]) -> NavigationTarget | None:
    """Return how a goal says where to go; None if it says no place."""
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


async def _frame_prefix(node: goalwire.Node, owner: str) -> str | None:
    """Ask a node for its parameter `frame_prefix`; None if it does not answer or has none."""
    try:
        with NodeParameters(node, owner, _PREFIX_S) as parameters:
            value = (await parameters.values(['frame_prefix'])).get('frame_prefix')
    except goalwire.GoalwireError:
        return None  # a peer may have any name
    if value is None or value.type != Type.STRING.value:
        return None
    prefix: str = value.string_value.lstrip('/')
    return prefix
