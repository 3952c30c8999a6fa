"""The visible robot: the shapes on the links of a URDF, and their frames.

The URDF comes from another program. So it is read within limits, and may refer only to meshes below the share
folders of installed packages. A robot's own programs read their URDF themselves, with masses and velocities
instead of shapes (for the humanoid: `humanoid.urdf`): neither side imports the other.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any, Literal, TypeAlias

from goalwire.apps.console.state.meshes import Meshes
from goalwire.errors import RemoteError
from goalwire.records import record
from goalwire.transforms import urdf
from goalwire.transforms.rigid import IDENTITY, Rigid
from goalwire.transforms.urdf import Kinematics
from goalwire.xml_tree import Element

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
    """The mesh's URL in the URDF: package://…"""


@record
class RobotModel:
    """A robot as its URDF describes it."""

    kinematics: Kinematics
    visuals: tuple[Visual, ...]
    bodies: tuple[Visual, ...] = ()
    """The shapes that stand for links whose meshes are missing: those for collisions."""


def root_pose(root: str, frames: Mapping[str, tuple[str, Rigid]]) -> tuple[str, Rigid]:
    """Return the topmost known ancestor frame of a link, or the link itself, and the link's pose in it."""
    pose, frame = IDENTITY, root
    seen = {root}
    while frame in frames:
        parent, motion = frames[frame]
        if parent in seen:
            break  # The published frames form a circle.
        seen.add(parent)
        pose = motion.after(pose)
        frame = parent
    return frame, pose


def likely_prefix(model: RobotModel, frames: Mapping[str, tuple[str, Rigid]], namespace: str) -> str:
    """Return the likely prefix of a robot's frames before the names of its links.

    Frames of equal robots differ only in their prefix. So the namespace is tried first as the prefix, then
    the empty prefix. Any other prefix may be another robot's: it is used only for a robot without a
    namespace, and only if there is exactly one.
    """
    names = {name for child, (parent, _) in frames.items() for name in (child, parent)}
    root = model.kinematics.root
    found = {name.removesuffix(root) for name in names if name.endswith(root)}
    for prefix in (f'{namespace.strip("/")}/' if namespace else '', ''):
        if prefix in found:
            return prefix
    found = {prefix for prefix in found if prefix.endswith(('/', '_'))}
    return found.pop() if len(found) == 1 and not namespace else ''


# -- reading -------------------------------------------------------------------------------------------------


def read_urdf(text: str) -> RobotModel:
    """Return the model of a URDF. Raises RemoteError."""
    try:
        robot = urdf.read_robot(text)
        kinematics = urdf.kinematics_of(robot)
        materials = {each.attributes.get('name', ''): _colour(each) for each in robot.findall('material')}
        links = robot.findall('link')
        visuals = [visual for link in links for visual in _visuals(link, materials)]
        bodies = [body for link in links for body in _visuals(link, materials, 'collision')]
    except ValueError as error:
        raise RemoteError(f'the robot_description cannot be shown: {error}') from None
    return RobotModel(kinematics, tuple(visuals), tuple(bodies))


def _visuals(
    link: Element, materials: Mapping[str, Colour | None], purpose: Literal['visual', 'collision'] = 'visual'
) -> Iterator[Visual]:
    name = link.attributes.get('name', '')
    for visual in link.findall(purpose):
        geometry = visual.find('geometry')
        if geometry is None or not geometry.children:
            continue
        shape = geometry.children[0]
        material = visual.find('material')
        colour = None
        if material is not None:
            colour = _colour(material) or materials.get(material.attributes.get('name', ''))
        origin = urdf.read_origin(visual)
        colour = colour or _GREY
        if shape.tag == 'box':
            yield Visual(
                name, 'box', urdf.read_vector(shape.attributes.get('size'), (1.0, 1.0, 1.0)), origin, colour
            )
        elif shape.tag == 'sphere':
            yield Visual(
                name, 'sphere', (urdf.read_number(shape.attributes.get('radius'), 0.1),), origin, colour
            )
        elif shape.tag in {'cylinder', 'capsule'}:
            size = (
                urdf.read_number(shape.attributes.get('radius'), 0.1),
                urdf.read_number(shape.attributes.get('length'), 0.1),
            )
            yield Visual(name, 'cylinder', size, origin, colour)
        elif shape.tag == 'mesh':
            scale = urdf.read_vector(shape.attributes.get('scale'), (1.0, 1.0, 1.0))
            yield Visual(name, 'mesh', scale, origin, colour, shape.attributes.get('filename', ''))


def _colour(material: Element) -> Colour | None:
    found = material.find('color')
    if found is None:
        return None
    parts = [min(max(float(part), 0.0), 1.0) for part in found.attributes.get('rgba', '').split()]
    return (parts[0], parts[1], parts[2], parts[3]) if len(parts) == 4 else None


# -- the page's scene ----------------------------------------------------------------------------------------


def scene_of(model: RobotModel, meshes: Meshes) -> tuple[list[dict[str, Any]], str, int]:
    """Return the visuals for the page's scene, why the last mesh was omitted, and how many were omitted."""
    urls: dict[str, str] = {}
    problem, missing = '', 0
    for visual in model.visuals:
        if visual.kind == 'mesh' and visual.mesh not in urls:
            try:
                urls[visual.mesh] = meshes.url(visual.mesh)
            except RemoteError as error:
                missing += 1
                problem = str(error)
    return as_scene(model, urls), problem, missing


def as_scene(model: RobotModel, mesh_urls: Mapping[str, str]) -> list[dict[str, Any]]:
    """Return the visuals for the page's scene.

    Meshes that have no address are left out; the shapes for collisions stand for them.
    """
    bare = {visual.link for visual in model.visuals if visual.kind == 'mesh' and visual.mesh not in mesh_urls}
    stand_ins = [body for body in model.bodies if body.link in bare]
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
        for visual in (*model.visuals, *stand_ins)
        if visual.kind != 'mesh' or visual.mesh in mesh_urls
    ]
