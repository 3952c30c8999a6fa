"""One robot as it is now: its description, joints, frames, battery, and the services that stop it."""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Mapping
from time import time
from typing import TYPE_CHECKING, Any

import goalwire
from goalwire.console.robot_model import RobotModel, read_urdf, root_pose
from goalwire.errors import RemoteError, UnknownInterfaceError, peer_text
from goalwire.records import record
from goalwire.transforms.rigid import Rigid

if TYPE_CHECKING:
    from goalwire.console.form_model import FormField
    from goalwire.console.topics import Reading, Topics

STRING = 'std_msgs/msg/String'
JOINT_STATE = 'sensor_msgs/msg/JointState'
BATTERY = 'sensor_msgs/msg/BatteryState'
TF = 'tf2_msgs/msg/TFMessage'
_STOPS = {'std_srvs/srv/Trigger', 'std_srvs/srv/SetBool', 'std_srvs/srv/Empty'}
_STOP_NAMES = ('estop', 'e_stop', 'emergency_stop')
_RELEASE_NAMES = ('release', 'reset', 'clear', 'resume')
_TRAIL = 600
_TRAIL_STEP = 0.03
_MOST_FRAMES = 2000


@record
class StopService:
    """A service that stops a robot."""

    name: str
    type_name: str

    @property
    def values(self) -> dict[str, bool]:
        """What its request holds."""
        return {'data': True} if self.type_name.endswith('SetBool') else {}


def stop_services(services: list[tuple[str, list[str]]]) -> list[StopService]:
    """Return the emergency stops among services: std_srvs types, named estop, e_stop or emergency_stop."""
    return [
        StopService(name, types[0])
        for name, types in services
        if types[0] in _STOPS
        and any(word in name.lower() for word in _STOP_NAMES)
        and not any(word in name.lower().rpartition('/')[2] for word in _RELEASE_NAMES)
    ]


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
        self.moved_at = 0.0
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
            (f'{self.namespace}/tf_static', TF, self._take_frames),
            ('/tf', TF, self._take_frames),
            ('/tf_static', TF, self._take_frames),
        ):
            has_publisher = bool(self._node.graph.publishers(topic))
            if topic in self._readings:
                if not has_publisher:
                    self._readings.pop(topic).close()  # one that comes back may offer another QoS
            elif has_publisher and type_name in there.get(topic, ()):
                try:
                    self._readings[topic] = self._topics.read(topic, type_name, listener)
                except UnknownInterfaceError as error:
                    self.problem = str(error)

    def _take_description(self, message: Any, _at: float) -> None:
        try:
            self.model = read_urdf(message.data)
            self.problem = ''
        except RemoteError as error:
            self.model, self.problem = None, peer_text(error, 300)
        self.version += 1

    def _take_joints(self, message: Any, at: float) -> None:
        for name, position in zip(message.name, message.position, strict=False):
            if math.isfinite(position):
                self.positions[name] = position
        self.moved_at = at

    def _take_frames(self, message: Any, at: float) -> None:
        for each in message.transforms:
            t, r = each.transform.translation, each.transform.rotation
            numbers = (t.x, t.y, t.z, r.x, r.y, r.z, r.w)
            length = math.hypot(*numbers[3:])
            if not all(map(math.isfinite, numbers)) or length < 1e-6 or len(self.frames) >= _MOST_FRAMES:
                continue
            turn = (r.x / length, r.y / length, r.z / length, r.w / length)
            child, parent = each.child_frame_id.lstrip('/'), each.header.frame_id.lstrip('/')
            self.frames[child] = (parent, Rigid((t.x, t.y, t.z), turn))
        self.moved_at = at
        if self.model is not None:
            self._lengthen_trail(root_pose(self.model.root, self.frames)[1])

    def pose(self) -> tuple[str, Rigid]:
        """Return the frame that everything is shown in, and the robot's pose there."""
        return root_pose(self.model.root if self.model is not None else '', self.frames)

    def _lengthen_trail(self, pose: Rigid) -> None:
        x, y, z = pose.translation
        if not self.trail or math.dist(self.trail[-1][:2], (x, y)) > _TRAIL_STEP:
            self.trail.append((x, y, z))

    def link_poses(self) -> list[tuple[str, list[float]]]:
        """Return each link's pose in the shown frame: x, y, z and the quaternion x, y, z, w."""
        _, base = self.pose()
        if self.model is None:
            return []
        poses = self.model.poses(self.positions, self.frames)
        found = []
        for link in self.model.links:
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
        """How long ago it moved, or said that it stands, in s; since 1970 where it never did."""
        return time() - self.moved_at

    def close(self) -> None:
        """Watch no more."""
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
    """To the PoseStamped; () where x and y are the goal's own."""


def navigation_target(action: str, type_name: str, fields: tuple[FormField, ...]) -> NavigationTarget | None:
    """Return how a goal says where to go; None where it says no place."""
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
