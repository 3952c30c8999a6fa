"""Reads the surfaces that a COLLADA file shows, as rviz shows them.

The unit of the file counts: coordinates are turned into metres. Its up axis does not: rviz tells Assimp to
ignore it (AI_CONFIG_IMPORT_COLLADA_IGNORE_UP_DIRECTION in rviz_rendering, assimp_loader.cpp). So the axes of
the file are those of the link, and the meshes of ROS packages are made for that. Lights, cameras, lines,
animations and the deformation by skeletons are left out, and so are the transforms <lookat> and <skew>.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from goalwire.apps.console.state.collada.document import (
    ColladaError,
    Document,
    Floats,
    elements_of,
    floats,
    inner,
)
from goalwire.apps.console.state.collada.geometry import Block, read_blocks
from goalwire.apps.console.state.collada.materials import Material, Materials
from goalwire.xml_tree import Element

MOST_ELEMENTS = 100_000
"""The most elements of a scene. Those of a node count each time that the node is used."""
MOST_TRIANGLES = 1_000_000


class Surface(NamedTuple):
    """The triangles of one material. Lengths in m."""

    material: Material | None
    """None if the file gives no colour."""
    spots: NDArray[np.float32]
    """The corners' places (n, 3)."""
    normals: NDArray[np.float32]
    """The surface's direction at each corner (n, 3), of length 1."""
    picture_spots: NDArray[np.float32] | None
    """The place of each corner in the picture (n, 2), from its lower left; None if no corner has one."""
    triangles: NDArray[np.uint32]
    """Corners by number (m, 3)."""


def read_collada(data: bytes, picture_url: Callable[[str], str] = lambda _: '') -> list[Surface]:
    """Return what a COLLADA file shows. Raises ColladaError.

    `picture_url` turns the name of a picture file into its address, or into '' if it cannot be shown.
    """
    with np.errstate(all='ignore'):  # what is too large is refused at the end
        return [
            _joined(material, blocks) for material, blocks in _placed(Document(data), picture_url).items()
        ]


def _placed(document: Document, picture_url: Callable[[str], str]) -> dict[Material | None, list[Block]]:
    """Return the parts of the scene at their places, by their materials."""
    materials = Materials(document, picture_url)
    known: dict[str, list[Block]] = {}
    placed: dict[Material | None, list[Block]] = {}
    triangles = 0
    for pose, instance in _instances(document):
        name = _geometry_name(document, instance)
        if name not in known:
            known[name] = read_blocks(document, document.get(name, 'geometry'))
        targets = _bound_materials(instance)
        for block in known[name]:
            triangles += len(block.triangles)
            if triangles > MOST_TRIANGLES:
                raise ColladaError(f'it has more than {MOST_TRIANGLES} triangles')
            material = materials.named(targets.get(block.material, block.material))
            placed.setdefault(material, []).append(_moved(block, pose))
    if not triangles:
        raise ColladaError('it shows no triangles')
    return placed


# -- the scene -----------------------------------------------------------------------------------------------


def _instances(document: Document) -> Iterator[tuple[Floats, Element]]:
    """Yield each use of a geometry in the scene, and its pose (4, 4) with the file's unit."""
    unit = inner(document.root, 'asset', 'unit')
    meters = _unit(unit)
    waiting = [(np.diag([meters, meters, meters, 1.0]), _scene(document))]
    visited = 0
    while waiting:
        pose, node = waiting.pop()
        visited += 1 + len(node.children)
        pose = pose @ _transform(node)
        for child in node.children:
            if child.tag == 'node':
                waiting.append((pose, child))
            elif child.tag == 'instance_node':
                waiting.append((pose, document.get(child.attributes.get('url', ''), 'node')))
            elif child.tag in {'instance_geometry', 'instance_controller'}:
                yield pose, child
        if visited > MOST_ELEMENTS:
            raise ColladaError(
                f'its scene has more than {MOST_ELEMENTS} elements, or nodes that contain themselves'
            )


def _scene(document: Document) -> Element:
    """Return the scene that the file shows: the one that it names, or else the first one."""
    named = inner(document.root, 'scene', 'instance_visual_scene')
    if named is not None:
        return document.get(named.attributes.get('url', ''), 'visual_scene')
    first = inner(document.root, 'library_visual_scenes', 'visual_scene')
    if first is None:
        raise ColladaError('it has no scene')
    return first


def _unit(unit: Element | None) -> float:
    text = '1' if unit is None else unit.attributes.get('meter', '1')
    try:
        meters = float(text)
    except ValueError:
        meters = math.nan
    if not 0.0 < meters < math.inf:
        raise ColladaError(f'its unit is {text[:40]!r} metres')
    return meters


def _transform(node: Element) -> Floats:
    """Return the transform (4, 4) of a node: the product of its transforms, from the first to the last."""
    pose = np.eye(4)
    for child in node.children:
        length = {'matrix': 16, 'translate': 3, 'rotate': 4, 'scale': 3}.get(child.tag)
        if length is None:
            continue
        values = floats(child)
        if len(values) != length:
            raise ColladaError(f'<{child.tag}> of line {child.line} has {len(values)} numbers, not {length}')
        step = np.eye(4)
        if child.tag == 'matrix':
            step = values.reshape(4, 4)
        elif child.tag == 'translate':
            step[:3, 3] = values
        elif child.tag == 'scale':
            step[range(3), range(3)] = values
        else:
            step[:3, :3] = _rotation(values[:3], math.radians(values[3]))
        pose = pose @ step
    return pose


def _rotation(axis: Floats, angle: float) -> Floats:
    """Return the matrix (3, 3) of a turn around an axis, in rad. An axis of length 0 turns nothing."""
    length = float(np.linalg.norm(axis))
    if length == 0.0:
        return np.eye(3)
    x, y, z = axis / length
    cross = np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
    turn: Floats = np.eye(3) + math.sin(angle) * cross + (1.0 - math.cos(angle)) * (cross @ cross)
    return turn


def _geometry_name(document: Document, instance: Element) -> str:
    """Return the id of the geometry that is used, directly or as the skin of a skeleton."""
    name = instance.attributes.get('url', '')
    if instance.tag == 'instance_controller':
        skin = document.get(name, 'controller').find('skin')
        if skin is None:
            raise ColladaError(f'<controller> of line {instance.line} is not a skin')
        name = skin.attributes.get('source', '')
    return name


def _bound_materials(instance: Element) -> dict[str, str]:
    """Return, by the names that a geometry has for its materials, the materials of this use of it."""
    return {
        each.attributes.get('symbol', ''): each.attributes.get('target', '')
        for each in elements_of(instance)
        if each.tag == 'instance_material'
    }


# -- surfaces ------------------------------------------------------------------------------------------------


def _moved(block: Block, pose: Floats) -> Block:
    """Return a block at its place in the scene. A mirroring pose turns its triangles round."""
    linear = pose[:3, :3]
    is_mirrored = np.linalg.det(linear) < 0
    cofactors = np.stack([np.cross(linear[(row + 1) % 3], linear[(row + 2) % 3]) for row in range(3)])
    normals = block.normals @ (-cofactors.T if is_mirrored else cofactors.T)
    lengths = np.linalg.norm(normals, axis=1, keepdims=True)
    return block._replace(
        spots=block.spots @ linear.T + pose[:3, 3],
        normals=normals / np.where(lengths > 0, lengths, 1.0),
        triangles=block.triangles[:, ::-1] if is_mirrored else block.triangles,
    )


def _joined(material: Material | None, blocks: list[Block]) -> Surface:
    offsets = np.cumsum([0, *(len(block.spots) for block in blocks)])
    spots = np.concatenate([block.spots for block in blocks])
    if not (np.abs(spots) < 1e30).all():
        raise ColladaError('it is larger than 1e30 m')
    picture_spots = None
    if material is not None and material.picture:
        picture_spots = np.concatenate([_picture_spots(block) for block in blocks])
    return Surface(
        material,
        spots.astype(np.float32),
        np.nan_to_num(np.concatenate([block.normals for block in blocks])).astype(np.float32),
        None if picture_spots is None else picture_spots.astype(np.float32),
        np.concatenate(
            [block.triangles + offset for block, offset in zip(blocks, offsets, strict=False)]
        ).astype(np.uint32),
    )


def _picture_spots(block: Block) -> Floats:
    return np.zeros((len(block.spots), 2)) if block.picture_spots is None else block.picture_spots
