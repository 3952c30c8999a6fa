"""Reads and checks a URDF: links, joints, and where the links are for given joint positions.

It reads what a robot's programs need: the tree, the joints' axes, limits, damping and mimics. Shapes and
masses are for viewers and physics engines. A document type is refused, so there are no entities to expand.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from xml.etree import ElementTree as ET

from humanoid.text import brief, quote

LARGEST = 16_000_000  # characters that a URDF may have
MOVING = ('revolute', 'continuous', 'prismatic')
KINDS = (*MOVING, 'fixed', 'floating', 'planar')

Vector = tuple[float, float, float]
Quaternion = tuple[float, float, float, float]  # x, y, z, w


class BadDescription(ValueError):
    """The text is not a valid URDF; the message says why."""


@dataclass(frozen=True)
class Transform:
    """The pose of a child frame in its parent: metres, and a quaternion of length 1."""

    translation: Vector = (0.0, 0.0, 0.0)
    rotation: Quaternion = (0.0, 0.0, 0.0, 1.0)

    def __matmul__(self, other: Transform) -> Transform:
        """Chain two transforms: `other` is given in this one's child frame, the result in its parent."""
        moved = rotate(self.rotation, other.translation)
        x, y, z = (a + b for a, b in zip(self.translation, moved, strict=True))
        return Transform((x, y, z), product(self.rotation, other.rotation))


@dataclass(frozen=True)
class Mimic:
    """How a joint mimics another: its position is `multiplier` times that of `joint`, plus `offset`."""

    joint: str
    multiplier: float = 1.0
    offset: float = 0.0


@dataclass(frozen=True)
class UrdfJoint:
    """A joint: positions in rad, velocity in rad/s, effort in N·m; m, m/s and N if it is prismatic."""

    name: str
    kind: str
    parent: str
    child: str
    origin: Transform
    axis: Vector = (1.0, 0.0, 0.0)
    lower: float = -math.inf
    upper: float = math.inf
    velocity: float = math.inf
    effort: float = math.inf
    damping: float = 0.0
    mimic: Mimic | None = None

    @property
    def moves(self) -> bool:
        """True if one number describes the joint's position."""
        return self.kind in MOVING

    def transform(self, position: float) -> Transform:
        """Return the child link's pose in the parent link's frame, for a position of the joint."""
        if not self.moves:
            return self.origin
        x, y, z = self.axis
        if self.kind == 'prismatic':
            return self.origin @ Transform((x * position, y * position, z * position))
        sine = math.sin(position / 2.0)
        return self.origin @ Transform(rotation=(x * sine, y * sine, z * sine, math.cos(position / 2.0)))


@dataclass(frozen=True)
class Description:
    """A robot as its URDF describes it: a tree of links, connected by joints."""

    name: str
    root: str
    links: Sequence[str]
    joints: Mapping[str, UrdfJoint]  # in the order of the URDF

    def positions(self, given: Mapping[str, float]) -> dict[str, float]:
        """Return the given joint positions, and those of the joints that mimic a given joint."""
        found = dict(given)
        for name, joint in self.joints.items():
            if joint.mimic is not None:
                factor, offset = joint.mimic.multiplier, joint.mimic.offset
                leader = joint.mimic.joint
                while leader not in given and (further := self.joints[leader].mimic) is not None:
                    offset += factor * further.offset
                    factor *= further.multiplier
                    leader = further.joint
                if leader in given:
                    found[name] = given[leader] * factor + offset
        return found

    def pose(self, link: str, given: Mapping[str, float]) -> Transform:
        """Return a link's pose in the root's frame; joints missing in `given` are at 0. Raises KeyError."""
        positions = self.positions(given)
        above = {joint.child: joint for joint in self.joints.values()}
        pose = Transform()
        if link not in self.links:
            raise KeyError(link)
        while link != self.root:
            joint = above[link]
            pose = joint.transform(positions.get(joint.name, 0.0)) @ pose
            link = joint.parent
        return pose


def parse(text: str) -> Description:
    """Parse and check the text of a URDF. Raises BadDescription."""
    robot = tree(text)
    if robot.tag != 'robot':
        raise BadDescription(f'its root is <{brief(robot.tag, 60)}>, not <robot>')
    links = _unique('link', (_read_name(link) for link in robot.findall('link')))
    if not links:
        raise BadDescription('it has no <link>')
    joints = [_joint(element) for element in robot.findall('joint')]
    _unique('joint', (joint.name for joint in joints))
    by_name = {joint.name: joint for joint in joints}
    root = _root(links, joints)
    _check_mimics(by_name)
    return Description(robot.get('name', ''), root, links, by_name)


def tree(text: str) -> ET.Element:
    """Parse a URDF's XML without further checks. Raises BadDescription."""
    if len(text) > LARGEST:
        raise BadDescription(f'{len(text)} characters are more than {LARGEST}')
    try:
        return ET.fromstring(text, ET.XMLParser(target=_NoDoctype()))  # noqa: S314 - has no entities
    except (ET.ParseError, ValueError) as error:
        if isinstance(error, BadDescription):
            raise
        raise BadDescription(f'it is not XML: {brief(str(error))}') from None


class _NoDoctype(ET.TreeBuilder):
    """Builds the tree, and refuses a document type as soon as the parser meets one."""

    def doctype(self, _name: str, _public: str | None, _system: str | None) -> None:
        raise BadDescription('it has a document type (<!DOCTYPE>), which descriptions need not have')


def _joint(element: ET.Element) -> UrdfJoint:
    name = _read_name(element)
    kind = element.get('type', '')
    where = f'joint {quote(name)}'
    if kind not in KINDS:
        raise BadDescription(f'{where}: its type is {quote(kind)}, not one of {", ".join(KINDS)}')
    limit, dynamics, mimic = element.find('limit'), element.find('dynamics'), element.find('mimic')
    lower, upper = -math.inf, math.inf
    if kind in ('revolute', 'prismatic'):
        if limit is None:
            raise BadDescription(f'{where}: a {kind} joint needs a <limit>')
        lower, upper = _number(limit, 'lower', where, 0.0), _number(limit, 'upper', where, 0.0)
        if lower > upper:
            raise BadDescription(f'{where}: its lower limit {lower:g} is above the upper one {upper:g}')
    return UrdfJoint(
        name,
        kind,
        _link_of(element, 'parent', where),
        _link_of(element, 'child', where),
        _origin(element.find('origin'), where),
        _axis(element.find('axis'), where) if kind in MOVING else (1.0, 0.0, 0.0),
        lower,
        upper,
        math.inf if limit is None else _number(limit, 'velocity', where, math.inf),
        math.inf if limit is None else _number(limit, 'effort', where, math.inf),
        0.0 if dynamics is None else _number(dynamics, 'damping', where, 0.0),
        None if mimic is None else _mimic(mimic, where),
    )


def _mimic(element: ET.Element, where: str) -> Mimic:
    multiplier = _number(element, 'multiplier', where, 1.0)
    return Mimic(element.get('joint', ''), multiplier, _number(element, 'offset', where, 0.0))


def _read_name(element: ET.Element) -> str:
    name = element.get('name', '')
    if not name:
        raise BadDescription(f'a <{element.tag}> has no name')
    return name


def _unique(what: str, names: Iterable[str]) -> Sequence[str]:
    seen: dict[str, None] = {}
    for name in names:
        if name in seen:
            raise BadDescription(f'two {what}s are named {quote(name)}')
        seen[name] = None
    return list(seen)


def _link_of(joint: ET.Element, side: str, where: str) -> str:
    element = joint.find(side)
    link = '' if element is None else element.get('link', '')
    if not link:
        raise BadDescription(f'{where}: it names no {side}')
    return link


def _number(element: ET.Element, key: str, where: str, default: float) -> float:
    text = element.get(key)
    if text is None:
        return default
    return _finite(text, f'{where}: {key}')


def _finite(text: str, what: str) -> float:
    try:
        number = float(text)
    except ValueError:
        number = math.nan
    if not math.isfinite(number):
        raise BadDescription(f'{what} is {quote(text)}, not a number')
    return number


def _vector(element: ET.Element | None, key: str, default: Vector, where: str) -> Vector:
    text = None if element is None else element.get(key)
    if text is None:
        return default
    numbers = [_finite(each, f'{where}: {key}') for each in text.split()]
    if len(numbers) != 3:
        raise BadDescription(f'{where}: {key} has {len(numbers)} numbers, not 3')
    return numbers[0], numbers[1], numbers[2]


def _origin(element: ET.Element | None, where: str) -> Transform:
    translation = _vector(element, 'xyz', (0.0, 0.0, 0.0), where)
    return Transform(translation, _of_rpy(_vector(element, 'rpy', (0.0, 0.0, 0.0), where)))


def _axis(element: ET.Element | None, where: str) -> Vector:
    x, y, z = _vector(element, 'xyz', (1.0, 0.0, 0.0), where)
    length = math.hypot(x, y, z)
    if not 1e-9 < length < math.inf:
        raise BadDescription(f'{where}: its axis has no direction')
    return x / length, y / length, z / length


def _root(links: Sequence[str], joints: Sequence[UrdfJoint]) -> str:
    """Return the only link without a parent. Raises BadDescription if the links do not form a tree."""
    known, below = set(links), dict[str, str]()
    for joint in joints:
        for link in (joint.parent, joint.child):
            if link not in known:
                raise BadDescription(f'joint {quote(joint.name)} names the link {quote(link)}: there is none')
        if joint.child in below:
            raise BadDescription(f'the link {quote(joint.child)} hangs on two joints')
        below[joint.child] = joint.parent
    roots = [link for link in links if link not in below]
    if len(roots) != 1:
        found = (
            f'{len(roots)}: {brief(", ".join(roots), 100)}' if roots else 'none: its joints go in a circle'
        )
        raise BadDescription(f'it needs one link at the root, and has {found}')
    children: dict[str, list[str]] = {}
    for child, parent in below.items():
        children.setdefault(parent, []).append(child)
    reached, ahead = 0, [roots[0]]
    while ahead:
        reached += 1
        ahead += children.get(ahead.pop(), [])
    if reached != len(links):
        raise BadDescription('some of its joints go in a circle')
    return roots[0]


def _check_mimics(joints: Mapping[str, UrdfJoint]) -> None:
    for joint in joints.values():
        seen, leader = {joint.name}, joint.mimic
        while leader is not None:
            if leader.joint not in joints:
                raise BadDescription(
                    f'joint {quote(joint.name)} mimics {quote(leader.joint)}, which is not there'
                )
            if leader.joint in seen:
                raise BadDescription(f'joint {quote(joint.name)} mimics itself')
            seen.add(leader.joint)
            leader = joints[leader.joint].mimic


# Quaternion functions are written out here: the robot's programs run on any ROS 2, so they import nothing
# from goalwire, and tf_transformations would be another package to install.
def product(a: Quaternion, b: Quaternion) -> Quaternion:
    """Return the rotation `b` followed by `a`, both about fixed axes."""
    ax, ay, az, aw = a
    bx, by, bz, bw = b
    return (
        aw * bx + ax * bw + ay * bz - az * by,
        aw * by - ax * bz + ay * bw + az * bx,
        aw * bz + ax * by - ay * bx + az * bw,
        aw * bw - ax * bx - ay * by - az * bz,
    )


def rotate(turn: Quaternion, vector: Vector) -> Vector:
    x, y, z, w = turn
    vx, vy, vz = vector
    tx, ty, tz = 2.0 * (y * vz - z * vy), 2.0 * (z * vx - x * vz), 2.0 * (x * vy - y * vx)
    return (
        vx + w * tx + y * tz - z * ty,
        vy + w * ty + z * tx - x * tz,
        vz + w * tz + x * ty - y * tx,
    )


def orientation(roll: float, pitch: float, yaw: float) -> Quaternion:
    """Return the rotation by roll, then pitch, then yaw (rad), about the parent's fixed axes."""
    return _of_rpy((roll, pitch, yaw))


def _of_rpy(angles: Vector) -> Quaternion:
    """Return the rotation by roll, pitch and yaw about the parent's fixed axes, in URDF's order."""
    (sr, cr), (sp, cp), (sy, cy) = ((math.sin(angle / 2.0), math.cos(angle / 2.0)) for angle in angles)
    return (
        sr * cp * cy - cr * sp * sy,
        cr * sp * cy + sr * cp * sy,
        cr * cp * sy - sr * sp * cy,
        cr * cp * cy + sr * sp * sy,
    )
