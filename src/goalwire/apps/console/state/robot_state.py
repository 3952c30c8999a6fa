"""One robot by its messages, live or from a bag: its description, joints and frames."""

from __future__ import annotations

import math
from collections import deque
from typing import Any

from goalwire.apps.console.state.robot_model import RobotModel, likely_prefix, read_urdf, root_pose
from goalwire.errors import RemoteError, peer_text
from goalwire.transforms.rigid import Rigid

_TRAIL = 600
_TRAIL_STEP = 0.03
_MOST_FRAMES = 2000


class RobotState:
    """The robot of one namespace; '' if its topics have the plain names /robot_description, /joint_states."""

    def __init__(self, namespace: str) -> None:
        self.namespace = namespace
        self.model: RobotModel | None = None
        self.problem = ''
        self.version = 0
        """A number that grows with each new description."""
        self.positions: dict[str, float] = {}
        self.frames: dict[str, tuple[str, Rigid]] = {}
        """By child frame: the parent frame, and the child's pose in the parent."""
        self.trail: deque[tuple[float, float, float]] = deque(maxlen=_TRAIL)
        self.moved_at: float | None = None
        """The time of the last joint state or frame, by the clock of the caller."""
        self.told_prefix: str | None = None
        """The prefix of frame names before link names, if a node has reported it."""
        self._links: frozenset[str] = frozenset()
        self._prefix: str | None = None

    def take_description(self, message: Any, _at: float) -> None:
        """Take a std_msgs/msg/String with a URDF; an unreadable one keeps the previous model."""
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

    @property
    def prefix(self) -> str:
        """The prefix of frame names before link names."""
        if self.told_prefix is not None:
            return self.told_prefix
        if self._prefix is None and self.model is not None:
            self._prefix = likely_prefix(self.model, self.frames, self.namespace)
        return self._prefix or ''

    def take_joints(self, message: Any, at: float) -> None:
        """Take a sensor_msgs/msg/JointState."""
        for name, position in zip(message.name, message.position, strict=False):
            if math.isfinite(position):
                self.positions[name] = position
        self.moved_at = at

    def take_frames(self, message: Any, at: float) -> None:
        """Take a tf2_msgs/msg/TFMessage of frames that move."""
        children = self._keep_frames(message)
        if self.model is None or any(map(self._is_own, children)):
            self.moved_at = at  # Robots share /tf: frames of other robots do not count.
        if self.model is not None and self.prefix + self.model.kinematics.root in self.frames:
            self._lengthen_trail(self.pose()[1])

    def take_static_frames(self, message: Any, _at: float) -> None:
        """Take static frames. They do not show that the robot is alive, because it may be gone already."""
        self._keep_frames(message)

    def _keep_frames(self, message: Any) -> list[str]:
        """Keep the frames of a message that have valid transforms, and return them."""
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
        """Return True if a frame belongs to a link of this robot."""
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
