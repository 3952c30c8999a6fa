"""The kinematics of a URDF: its links and joints, and each link's pose in its parent for given positions.

The text comes from another program or another person: its size is limited, and links and joints that do not
form a tree are refused. The rules are those of urdfdom, the reader of ROS 2; see
http://wiki.ros.org/urdf/XML/joint. Shapes are not read here, but by the programs that draw them.
"""

from __future__ import annotations

import math
from collections.abc import Mapping

from goalwire import xml_tree
from goalwire.errors import peer_text
from goalwire.records import record
from goalwire.transforms.rigid import IDENTITY, NO_ROTATION, Quaternion, Rigid, Vector
from goalwire.xml_tree import Element

MOST_CHARACTERS = 16 << 20
MOST_LINKS = 2000
MOVABLE = ('revolute', 'continuous', 'prismatic')
KINDS = (*MOVABLE, 'fixed', 'floating', 'planar')


class UrdfError(ValueError):
    """The text does not describe a robot; the message says why."""


@record
class Mimic:
    """The rule of a joint that mimics another: its position is `multiplier` times the position of `joint`,
    plus `offset`.
    """

    joint: str
    multiplier: float = 1.0
    offset: float = 0.0


@record
class Joint:
    """A joint between a link and its parent. Positions are in rad, those of prismatic joints in m."""

    name: str
    kind: str
    parent: str
    child: str
    origin: Rigid = IDENTITY
    """The pose of the child link in the parent link at the joint's position 0."""
    axis: Vector = (1.0, 0.0, 0.0)
    """The joint's axis: a vector of length 1 in the joint's frame."""
    lower: float = -math.pi
    upper: float = math.pi
    soft_lower: float = -math.inf
    """The lower limit of the joint's safety controller."""
    soft_upper: float = math.inf
    mimic: Mimic | None = None

    @property
    def is_movable(self) -> bool:
        """True if one number describes the joint's position."""
        return self.kind in MOVABLE

    @property
    def is_free(self) -> bool:
        """True if the joint has its own position and does not mimic another joint."""
        return self.is_movable and self.mimic is None

    def motion(self, position: float) -> Rigid:
        """Return the pose of the child link in the parent link for a position of the joint."""
        x, y, z = self.axis
        if self.kind in {'revolute', 'continuous'}:
            half = math.sin(position / 2)
            turn: Quaternion = (x * half, y * half, z * half, math.cos(position / 2))
            return self.origin.after(Rigid((0.0, 0.0, 0.0), turn))
        if self.kind == 'prismatic':
            return self.origin.after(Rigid((x * position, y * position, z * position), NO_ROTATION))
        return self.origin


@record
class Kinematics:
    """The links and joints of a robot, which form a tree."""

    name: str
    root: str
    links: tuple[str, ...]
    joints: tuple[Joint, ...]
    """The joints, limb by limb, from the root outwards: each joint comes after the joint of its
    parent link.
    """
    joint_names: tuple[str, ...]
    """The names of the joints, in the order of the text."""

    def positions(self, given: Mapping[str, float]) -> dict[str, float]:
        """Return the given positions, and the positions of joints that mimic a joint with a given position.

        A joint may mimic a joint that mimics another. If a joint's own position is given, that position is
        returned.
        """
        found = dict(given)
        by_name = {joint.name: joint for joint in self.joints if joint.mimic is not None}
        for name, joint in by_name.items():
            follower, factor, offset = joint.mimic, 1.0, 0.0
            while name not in given and follower is not None:
                offset += factor * follower.offset
                factor *= follower.multiplier
                if follower.joint in given:
                    found[name] = given[follower.joint] * factor + offset
                    break
                leader = by_name.get(follower.joint)
                follower = None if leader is None else leader.mimic
        return found

    def poses(
        self, positions: Mapping[str, float], frames: Mapping[str, tuple[str, Rigid]], prefix: str = ''
    ) -> dict[str, Rigid]:
        """Return each link's pose in the root link. A link's frame is named `prefix` plus the link's name.

        If `frames` has a link's pose in its parent, that pose is used; else the joint's position (0 if
        unknown).
        """
        at_rest = {joint.name: 0.0 for joint in self.joints if joint.is_free}
        finite = {name: position for name, position in positions.items() if math.isfinite(position)}
        complete = self.positions(at_rest | finite)
        poses = {self.root: IDENTITY}
        for joint in self.joints:
            parent = poses[joint.parent]
            known = frames.get(prefix + joint.child)
            if known is not None and known[0] == prefix + joint.parent:
                poses[joint.child] = parent.after(known[1])
                continue
            poses[joint.child] = parent.after(joint.motion(complete.get(joint.name, 0.0)))
        return poses


def read_kinematics(text: str) -> Kinematics:
    """Return the kinematics of a URDF. Raises UrdfError."""
    return kinematics_of(read_robot(text))


def read_robot(text: str) -> Element:
    """Return the element <robot> of a URDF. Raises UrdfError."""
    if not text.strip():
        raise UrdfError('the URDF is empty')
    if len(text) > MOST_CHARACTERS:
        raise UrdfError(f'its {len(text)} characters are too many: at most {MOST_CHARACTERS} are read')
    try:
        top = xml_tree.read(text)
    except xml_tree.XmlError as error:
        raise UrdfError(f'it cannot be read as XML: {error}') from None
    if top.tag != 'robot':
        raise UrdfError(f'it is not a URDF: it begins with <{peer_text(top.tag, 60)}>, not with <robot>')
    return top


def kinematics_of(robot: Element) -> Kinematics:
    """Return the kinematics of an element <robot>. Raises UrdfError."""
    links = [_name_of(each) for each in robot.findall('link')]
    _refuse_twins('links', links)
    if not links or len(links) > MOST_LINKS:
        raise UrdfError(f'it has {len(links)} links: a robot has 1 to {MOST_LINKS}')
    joints = [_read_joint(each) for each in robot.findall('joint')]
    _refuse_twins('joints', [joint.name for joint in joints])
    root, ordered = _order(links, joints)
    _check_mimics({joint.name: joint for joint in joints})
    names = tuple(joint.name for joint in joints)
    return Kinematics(robot.attributes.get('name', ''), root, tuple(links), tuple(ordered), names)


def _order(links: list[str], joints: list[Joint]) -> tuple[str, list[Joint]]:
    """Return the root link, and the joints in the order from the root outwards."""
    known, children = set(links), {joint.child for joint in joints}
    by_parent: dict[str, list[Joint]] = {}
    for joint in joints:
        for link in (joint.parent, joint.child):
            if link not in known:
                raise UrdfError(
                    f'the joint {_quote(joint.name)} joins the link {_quote(link)}: it is unknown'
                )
        by_parent.setdefault(joint.parent, []).append(joint)
    roots = [link for link in links if link not in children]
    if len(roots) != 1:
        names = peer_text(', '.join(roots), 100) or 'its joints go in a circle'
        raise UrdfError(f'it has {len(roots)} root links, and needs one: {names}')
    ordered: list[Joint] = []
    reached, waiting = {roots[0]}, by_parent.get(roots[0], [])[::-1]
    while waiting:  # limb by limb, the order in which people list joints
        joint = waiting.pop()
        if joint.child in reached:
            raise UrdfError(f'the link {_quote(joint.child)} hangs on two joints')
        ordered.append(joint)
        reached.add(joint.child)
        waiting += by_parent.get(joint.child, [])[::-1]
    if len(reached) != len(links):
        raise UrdfError('some of its joints go in a circle')
    return roots[0], ordered


def _check_mimics(joints: Mapping[str, Joint]) -> None:
    for joint in joints.values():
        seen, leader = {joint.name}, joint.mimic
        while leader is not None:
            if leader.joint not in joints:
                raise UrdfError(
                    f'the joint {_quote(joint.name)} mimics {_quote(leader.joint)}, which is unknown'
                )
            if leader.joint in seen:
                raise UrdfError(f'the joint {_quote(joint.name)} mimics itself')
            seen.add(leader.joint)
            leader = joints[leader.joint].mimic


def _read_joint(each: Element) -> Joint:
    name = _name_of(each)
    kind = each.attributes.get('type', '')
    if kind not in KINDS:
        raise UrdfError(f'the type of the joint {_quote(name)} is {_quote(kind)}, not {", ".join(KINDS)}')
    try:
        origin = read_origin(each)
        axis = _read_axis(each) if kind in MOVABLE else (1.0, 0.0, 0.0)
        lower, upper = _read_limits(each, kind)
        safety, mimic = each.find('safety_controller'), each.find('mimic')
        soft = {} if safety is None else safety.attributes
        return Joint(
            name,
            kind,
            _find_link(each, 'parent'),
            _find_link(each, 'child'),
            origin,
            axis,
            lower,
            upper,
            -math.inf if 'soft_lower_limit' not in soft else read_number(soft['soft_lower_limit'], 0.0),
            math.inf if 'soft_upper_limit' not in soft else read_number(soft['soft_upper_limit'], 0.0),
            None if mimic is None else _read_mimic(mimic),
        )
    except UrdfError as error:
        raise UrdfError(f'the joint {_quote(name)}: {error}') from None


def _read_limits(joint: Element, kind: str) -> tuple[float, float]:
    limit = joint.find('limit')
    if kind not in {'revolute', 'prismatic'}:
        return -math.pi, math.pi
    if limit is None:
        raise UrdfError(f'a {kind} joint needs a <limit>')
    lower, upper = (read_number(limit.attributes.get(side), 0.0) for side in ('lower', 'upper'))
    if lower > upper:
        raise UrdfError(f'its lower limit {lower:g} is above its upper limit {upper:g}')
    return lower, upper


def _read_axis(joint: Element) -> Vector:
    found = joint.find('axis')
    axis = read_vector(None if found is None else found.attributes.get('xyz'), (1.0, 0.0, 0.0))
    length = math.hypot(*axis)
    if not 1e-9 < length < math.inf:
        raise UrdfError('its axis has no direction')
    x, y, z = (part / length for part in axis)
    return x, y, z


def _read_mimic(mimic: Element) -> Mimic:
    given = mimic.attributes
    multiplier, offset = read_number(given.get('multiplier'), 1.0), read_number(given.get('offset'), 0.0)
    return Mimic(given.get('joint', ''), multiplier, offset)


def _find_link(joint: Element, side: str) -> str:
    found = joint.find(side)
    link = '' if found is None else found.attributes.get('link', '')
    if not link:
        raise UrdfError(f'it names no {side} link')
    return link


def _name_of(each: Element) -> str:
    name = each.attributes.get('name', '')
    if not name:
        raise UrdfError(f'line {each.line}: a <{each.tag}> has no name')
    return name


def _refuse_twins(kind: str, names: list[str]) -> None:
    if len(set(names)) != len(names):
        twin = next(name for name in names if names.count(name) > 1)
        raise UrdfError(f'two {kind} have the name {_quote(twin)}: they need different names')


def read_origin(owner: Element) -> Rigid:
    """Return the <origin> of a joint or a shape; the identity if it has none. Raises UrdfError."""
    origin = owner.find('origin')
    if origin is None:
        return IDENTITY
    roll_pitch_yaw = read_vector(origin.attributes.get('rpy'))
    return Rigid(read_vector(origin.attributes.get('xyz')), _from_rpy(*roll_pitch_yaw))


def _from_rpy(roll: float, pitch: float, yaw: float) -> Quaternion:
    """Return the rotation about the fixed axes x (roll), then y (pitch), then z (yaw)."""
    cr, sr = math.cos(roll / 2), math.sin(roll / 2)
    cp, sp = math.cos(pitch / 2), math.sin(pitch / 2)
    cy, sy = math.cos(yaw / 2), math.sin(yaw / 2)
    return (
        sr * cp * cy - cr * sp * sy,
        cr * sp * cy + sr * cp * sy,
        cr * cp * sy - sr * sp * cy,
        cr * cp * cy + sr * sp * sy,
    )


def read_vector(text: str | None, default: Vector = (0.0, 0.0, 0.0)) -> Vector:
    """Parse three numbers that spaces separate. Raises UrdfError."""
    if text is None:
        return default
    parts = [read_number(part, 0.0) for part in text.split()]
    if len(parts) != 3:
        raise UrdfError(f'three numbers are needed, not {_quote(text)}')
    return parts[0], parts[1], parts[2]


def read_number(text: str | None, default: float) -> float:
    """Parse a finite number. Raises UrdfError."""
    try:
        number = default if text is None else float(text)
    except ValueError:
        raise UrdfError(f'a number is needed, not {_quote(text or "")}') from None
    if not math.isfinite(number):
        raise UrdfError(f'{_quote(text or "")} is not finite')
    return number


def _quote(name: str) -> str:
    return f"'{peer_text(name, 60)}'"
