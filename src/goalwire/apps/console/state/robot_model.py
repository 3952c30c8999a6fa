"""A robot for the eye: links, joints and shapes of a URDF, and where joint states and frames put them.

The URDF comes from another program: it is read within bounds, and names files of this machine only below the
share folders of packages that are installed here, and only meshes. A robot's own programs read their URDF
themselves (the humanoid's: `humanoid.urdf`), with masses and velocities in place of shapes: they run without
this library, and this library without them.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from hashlib import sha256
from pathlib import Path
from typing import Any, Literal, TypeAlias
from urllib.parse import unquote

from goalwire import xml_tree
from goalwire.errors import RemoteError
from goalwire.records import record
from goalwire.transforms.rigid import IDENTITY, Quaternion, Rigid, Vector
from goalwire.xml_tree import Element

MOST_CHARACTERS = 8 << 20
MOST_MESH_BYTES = 64 << 20
MESH_SUFFIXES = frozenset({'.stl', '.glb', '.gltf'})
_MOST_LINKS = 500

ShapeKind: TypeAlias = Literal['box', 'cylinder', 'sphere', 'mesh']
Colour: TypeAlias = tuple[float, float, float, float]
_GREY: Colour = (0.62, 0.66, 0.72, 1.0)


@record
class Visual:
    """A shape on a link."""

    link: str
    kind: ShapeKind
    size: tuple[float, ...]
    """Box: x, y, z; cylinder: radius, length; sphere: radius; mesh: its scale. In metres."""
    origin: Rigid
    colour: Colour = _GREY
    mesh: str = ''
    """As the URDF names it: package://…"""


@record
class Joint:
    """A joint, with its limits if it has any."""

    name: str
    kind: str
    parent: str
    child: str
    origin: Rigid
    axis: Vector = (1.0, 0.0, 0.0)
    lower: float = -math.pi
    upper: float = math.pi
    mimic: tuple[str, float, float] | None = None
    """The joint that it follows, factor and offset."""

    @property
    def is_movable(self) -> bool:
        """Whether it has a position of its own."""
        return self.kind in {'revolute', 'continuous', 'prismatic'} and self.mimic is None


@record
class RobotModel:
    """A robot as its URDF describes it."""

    name: str
    root: str
    links: tuple[str, ...]
    joints: tuple[Joint, ...]
    """Each after the one that its parent link hangs on."""
    visuals: tuple[Visual, ...]

    def poses(
        self, positions: Mapping[str, float], frames: Mapping[str, tuple[str, Rigid]], prefix: str = ''
    ) -> dict[str, Rigid]:
        """Return each link's pose in the root link; a link's frame has its name after `prefix`.

        A link whose frame is known takes it from there; else the joint's position counts, 0 where unknown.
        """
        poses = {self.root: IDENTITY}
        for joint in self.joints:
            parent = poses[joint.parent]
            known = frames.get(prefix + joint.child)
            if known is not None and known[0] == prefix + joint.parent:
                poses[joint.child] = parent.after(known[1])
            else:
                poses[joint.child] = parent.after(joint.origin.after(_motion(joint, positions)))
        return poses


def _motion(joint: Joint, positions: Mapping[str, float]) -> Rigid:
    if joint.mimic is not None:
        name, factor, offset = joint.mimic
        position = positions.get(name, 0.0) * factor + offset
    else:
        position = positions.get(joint.name, 0.0)
    if not math.isfinite(position):
        position = 0.0
    x, y, z = joint.axis
    if joint.kind in {'revolute', 'continuous'}:
        half = math.sin(position / 2)
        return Rigid((0.0, 0.0, 0.0), (x * half, y * half, z * half, math.cos(position / 2)))
    if joint.kind == 'prismatic':
        return Rigid((x * position, y * position, z * position), (0.0, 0.0, 0.0, 1.0))
    return IDENTITY


def root_pose(root: str, frames: Mapping[str, tuple[str, Rigid]]) -> tuple[str, Rigid]:
    """Return the topmost frame that a link hangs on, and its pose in it; itself if none is known."""
    pose, frame = IDENTITY, root
    seen = {root}
    while frame in frames:
        parent, motion = frames[frame]
        if parent in seen:
            break  # a circle, which somebody publishes
        seen.add(parent)
        pose = motion.after(pose)
        frame = parent
    return frame, pose


def likely_prefix(model: RobotModel, frames: Mapping[str, tuple[str, Rigid]], namespace: str) -> str:
    """Return what seems to stand before the names of a robot's links in its frames.

    Robots of one kind differ in nothing else. So the prefix counts that the namespace gives, else the empty
    one. Any other one may be another robot's: it counts only for a robot without a namespace, if it is alone.
    """
    names = {name for child, (parent, _) in frames.items() for name in (child, parent)}
    root = model.root
    found = {name.removesuffix(root) for name in names if name.endswith(root)}
    for prefix in (f'{namespace.strip("/")}/' if namespace else '', ''):
        if prefix in found:
            return prefix
    found = {prefix for prefix in found if prefix.endswith(('/', '_'))}
    return found.pop() if len(found) == 1 and not namespace else ''


# -- reading -------------------------------------------------------------------------------------------------


def read_urdf(text: str) -> RobotModel:
    """Return the model of a URDF. Raises RemoteError."""
    if len(text) > MOST_CHARACTERS:
        raise RemoteError(f'the robot_description has {len(text)} characters: too many')
    try:
        top = xml_tree.read(text)
    except xml_tree.XmlError as error:
        raise RemoteError(f'the robot_description is not XML: {error}') from None
    if top.tag != 'robot':
        raise RemoteError(f'the robot_description is no URDF: it begins with <{top.tag}>, not <robot>')
    links = [each.attributes.get('name', '') for each in top.findall('link')]
    if not links or len(links) > _MOST_LINKS or len(set(links)) != len(links):
        raise RemoteError(
            f'the robot_description has {len(links)} links; 1 to {_MOST_LINKS} of different names'
        )
    try:
        joints = [_joint(each) for each in top.findall('joint')]
        materials = {each.attributes.get('name', ''): _colour(each) for each in top.findall('material')}
        visuals = [visual for link in top.findall('link') for visual in _visuals(link, materials)]
    except ValueError as error:
        raise RemoteError(f'the robot_description has a value that is not a number: {error}') from None
    root, ordered = _ordered(links, joints)
    return RobotModel(top.attributes.get('name', ''), root, tuple(links), tuple(ordered), tuple(visuals))


def _ordered(links: list[str], joints: list[Joint]) -> tuple[str, list[Joint]]:
    """Return the root link, and the joints from there outwards."""
    children = {joint.child for joint in joints}
    roots = [link for link in links if link not in children]
    if len(roots) != 1:
        raise RemoteError(f'the robot_description has {len(roots)} root links, not one')
    by_parent: dict[str, list[Joint]] = {}
    for joint in joints:
        if joint.parent not in links or joint.child not in links:
            raise RemoteError(f"the joint '{joint.name}' joins a link that there is not")
        by_parent.setdefault(joint.parent, []).append(joint)
    ordered: list[Joint] = []
    reached, waiting = {roots[0]}, by_parent.get(roots[0], [])[::-1]
    while waiting:  # a limb at a time, as people name joints
        joint = waiting.pop()
        if joint.child in reached:
            raise RemoteError(f"the link '{joint.child}' hangs on two joints")
        ordered.append(joint)
        reached.add(joint.child)
        waiting += by_parent.get(joint.child, [])[::-1]
    if len(reached) != len(links):
        raise RemoteError('the robot_description has links in a circle')
    return roots[0], ordered


def _joint(each: Element) -> Joint:
    limit, mimic, axis = each.find('limit'), each.find('mimic'), each.find('axis')
    kind = each.attributes.get('type', 'fixed')
    lower, upper = (0.0, 0.0) if kind == 'prismatic' else (-math.pi, math.pi)
    if limit is not None and kind != 'continuous':
        lower, upper = (
            _number(limit.attributes.get('lower'), 0.0),
            _number(limit.attributes.get('upper'), 0.0),
        )
    direction = _vector(axis.attributes.get('xyz') if axis is not None else None, (1.0, 0.0, 0.0))
    length = math.sqrt(sum(part * part for part in direction)) or 1.0
    return Joint(
        each.attributes.get('name', ''),
        kind,
        _attribute(each, 'parent', 'link'),
        _attribute(each, 'child', 'link'),
        _origin(each),
        (direction[0] / length, direction[1] / length, direction[2] / length),
        lower,
        upper,
        None
        if mimic is None
        else (
            mimic.attributes.get('joint', ''),
            _number(mimic.attributes.get('multiplier'), 1.0),
            _number(mimic.attributes.get('offset'), 0.0),
        ),
    )


def _visuals(link: Element, materials: Mapping[str, Colour | None]) -> Iterator[Visual]:
    name = link.attributes.get('name', '')
    for visual in link.findall('visual'):
        geometry = visual.find('geometry')
        if geometry is None or not geometry.children:
            continue
        shape = geometry.children[0]
        material = visual.find('material')
        colour = None
        if material is not None:
            colour = _colour(material) or materials.get(material.attributes.get('name', ''))
        origin = _origin(visual)
        colour = colour or _GREY
        if shape.tag == 'box':
            yield Visual(name, 'box', _vector(shape.attributes.get('size'), (1.0, 1.0, 1.0)), origin, colour)
        elif shape.tag == 'sphere':
            yield Visual(name, 'sphere', (_number(shape.attributes.get('radius'), 0.1),), origin, colour)
        elif shape.tag in {'cylinder', 'capsule'}:
            size = (
                _number(shape.attributes.get('radius'), 0.1),
                _number(shape.attributes.get('length'), 0.1),
            )
            yield Visual(name, 'cylinder', size, origin, colour)
        elif shape.tag == 'mesh':
            scale = _vector(shape.attributes.get('scale'), (1.0, 1.0, 1.0))
            yield Visual(name, 'mesh', scale, origin, colour, shape.attributes.get('filename', ''))


def _colour(material: Element) -> Colour | None:
    found = material.find('color')
    if found is None:
        return None
    parts = [min(max(float(part), 0.0), 1.0) for part in found.attributes.get('rgba', '').split()]
    return (parts[0], parts[1], parts[2], parts[3]) if len(parts) == 4 else None


def _origin(owner: Element) -> Rigid:
    origin = owner.find('origin')
    if origin is None:
        return IDENTITY
    return Rigid(_vector(origin.attributes.get('xyz')), _from_rpy(*_vector(origin.attributes.get('rpy'))))


def _from_rpy(roll: float, pitch: float, yaw: float) -> Quaternion:
    """Return the rotation about fixed x, then y, then z."""
    cr, sr = math.cos(roll / 2), math.sin(roll / 2)
    cp, sp = math.cos(pitch / 2), math.sin(pitch / 2)
    cy, sy = math.cos(yaw / 2), math.sin(yaw / 2)
    return (
        sr * cp * cy - cr * sp * sy,
        cr * sp * cy + sr * cp * sy,
        cr * cp * sy - sr * sp * cy,
        cr * cp * cy + sr * sp * sy,
    )


def _vector(text: str | None, default: Vector = (0.0, 0.0, 0.0)) -> Vector:
    if text is None:
        return default
    parts = [_number(part, 0.0) for part in text.split()]
    if len(parts) != 3:
        raise ValueError(f'three numbers are wanted, not {text[:60]!r}')
    return parts[0], parts[1], parts[2]


def _number(text: str | None, default: float) -> float:
    number = default if text is None else float(text)
    if not math.isfinite(number):
        raise ValueError(f'{text!r} is not finite')
    return number


def _attribute(owner: Element, tag: str, name: str) -> str:
    found = owner.find(tag)
    return '' if found is None else found.attributes.get(name, '')


# -- meshes --------------------------------------------------------------------------------------------------


def mesh_file(name: str) -> Path:
    """Return the file of a mesh that is named package://PACKAGE/…; raises RemoteError for all else."""
    from ament_index_python.packages import PackageNotFoundError, get_package_share_directory

    prefix = 'package://'
    if not name.startswith(prefix):
        raise RemoteError(f'meshes are taken from package://…, not from {name[:80]!r}')
    package, _, inner = unquote(name.removeprefix(prefix)).partition('/')
    try:
        share = Path(get_package_share_directory(package)).resolve()
    except (PackageNotFoundError, ValueError):
        raise RemoteError(f"the package '{package[:80]}' is not installed here") from None
    file = (share / inner).resolve()
    if not file.is_relative_to(share) or file.suffix.lower() not in MESH_SUFFIXES:
        raise RemoteError(f'{name[:80]!r} is not a mesh of the package: {", ".join(sorted(MESH_SUFFIXES))}')
    if not file.is_file() or file.stat().st_size > MOST_MESH_BYTES:
        raise RemoteError(f'{name[:80]!r} is not there, or too large')
    return file


class Meshes:
    """The mesh files that descriptions have named, by keys that stand for just those."""

    def __init__(self) -> None:
        self._files: dict[str, Path] = {}

    def url(self, name: str) -> str:
        """Return the address of a mesh; raises RemoteError if it may not, or cannot, be served."""
        file = mesh_file(name)
        key = sha256(str(file).encode()).hexdigest()[:24] + file.suffix.lower()
        self._files[key] = file
        return f'/console/mesh/{key}'

    def file(self, key: str) -> Path | None:
        """Return the file that a key stands for."""
        return self._files.get(key)


def as_scene(model: RobotModel, mesh_urls: Mapping[str, str]) -> list[dict[str, Any]]:
    """Return the visuals as the page's scene wants them; meshes without an address are left out."""
    return [
        {
            'link': visual.link,
            'kind': visual.kind,
            'size': list(visual.size),
            'xyz': list(visual.origin.translation),
            'quat': list(visual.origin.rotation),
            'rgba': list(visual.colour),
            'url': mesh_urls.get(visual.mesh, ''),
        }
        for visual in model.visuals
        if visual.kind != 'mesh' or visual.mesh in mesh_urls
    ]
