"""The geometries of a COLLADA file: their polygons as triangles with corners."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from goalwire.apps.console.state.collada.document import (
    ColladaError,
    Document,
    Floats,
    Integers,
    inner,
    integer,
    integers,
)
from goalwire.apps.console.state.collada.polygons import (
    triangles_of_fans,
    triangles_of_polygons,
    triangles_of_strips,
)
from goalwire.xml_tree import Element

MOST_INPUTS = 32
_PRIMITIVES = frozenset({'triangles', 'polylist', 'polygons', 'tristrips', 'trifans'})


class Block(NamedTuple):
    """The triangles of one element of a geometry, in the geometry's unit."""

    material: str
    """The geometry's own name for the material."""
    spots: Floats
    """The corners' places (n, 3)."""
    normals: Floats
    """The surface's direction at each corner (n, 3)."""
    picture_spots: Floats | None
    """The place of each corner in a picture (n, 2)."""
    triangles: Integers
    """Corners by number (m, 3)."""


class _Input(NamedTuple):
    """The values that the indices at one place of each corner select."""

    offset: int
    values: Floats


def read_blocks(document: Document, geometry: Element) -> list[Block]:
    """Return the triangles of a geometry. Raises ColladaError."""
    mesh = geometry.find('mesh')
    if mesh is None:
        return []  # a spline
    found = (_block(document, each) for each in mesh.children if each.tag in _PRIMITIVES)
    return [block for block in found if block is not None]


def _block(document: Document, primitive: Element) -> Block | None:
    """Return the triangles of an element; None if it has none."""
    inputs, width = _inputs(document, primitive)
    if 'POSITION' not in inputs:
        raise ColladaError(f'<{primitive.tag}> of line {primitive.line} names no positions')
    sizes, indices = _indices(primitive, width)
    columns = {}
    for name, (offset, values) in inputs.items():
        column = indices[:, offset]
        if len(column) and not 0 <= column.min() <= column.max() < len(values):
            raise ColladaError(
                f'<{primitive.tag}> of line {primitive.line} refers to a {name.lower()} that is not there'
            )
        columns[name] = column
    triangles = _triangles(primitive.tag, sizes, inputs['POSITION'].values[columns['POSITION']])
    if not len(triangles):
        return None
    is_flat = 'NORMAL' not in inputs
    if is_flat:  # each triangle has corners of its own
        kept = triangles.reshape(-1)
        triangles = np.arange(len(kept)).reshape(-1, 3)
    else:
        kept, triangles = _shared(list(columns.values()), triangles)
    given = {name: values[columns[name][kept]] for name, (_, values) in inputs.items()}
    return Block(
        primitive.attributes.get('material', ''),
        given['POSITION'],
        _face_normals(given['POSITION']) if is_flat else given['NORMAL'],
        given.get('TEXCOORD'),
        triangles,
    )


# -- what corners have ---------------------------------------------------------------------------------------


def _inputs(document: Document, primitive: Element) -> tuple[dict[str, _Input], int]:
    """Return an element's inputs that are shown, and how many indices each of its corners has."""
    found: dict[str, _Input] = {}
    width = 1
    given = primitive.findall('input')
    if len(given) > MOST_INPUTS:
        raise ColladaError(f'<{primitive.tag}> of line {primitive.line} has more than {MOST_INPUTS} inputs')
    for each in given:
        offset = integer(each, 'offset', 0)
        if offset >= MOST_INPUTS:
            raise ColladaError(f'<input> of line {each.line} has an offset above {MOST_INPUTS - 1}')
        width = max(width, offset + 1)
        if each.attributes.get('semantic') == 'VERTEX':
            vertices = document.get(each.attributes.get('source', ''), 'vertices')
            shared = vertices.findall('input')[:MOST_INPUTS]
        else:
            shared = [each]
        for one in shared:
            semantic = one.attributes.get('semantic', '')
            columns = {'POSITION': 3, 'NORMAL': 3, 'TEXCOORD': 2}.get(semantic)
            if columns is not None and semantic not in found:
                source = document.get(one.attributes.get('source', ''), 'source')
                found[semantic] = _Input(offset, _values(document, source)[:, :columns])
                if found[semantic].values.shape[1] < columns:
                    raise ColladaError(
                        f'<source> of line {source.line} has too few numbers for each {semantic}'
                    )
    return found, width


def _values(document: Document, source: Element) -> Floats:
    """Return the numbers of a source, a row for each of its items."""
    accessor = inner(source, 'technique_common', 'accessor')
    if accessor is None:
        raise ColladaError(f'<source> of line {source.line} does not say how its numbers are read')
    values = document.array(accessor.attributes.get('source', ''))
    stride, begin = integer(accessor, 'stride', 1), integer(accessor, 'offset', 0)
    count = min(integer(accessor, 'count', 0), max(len(values) - begin, 0) // max(stride, 1))
    return values[begin : begin + count * stride].reshape(count, stride)


def _face_normals(spots: Floats) -> Floats:
    """Return the directions of triangles for each of their corners: (3 m, 3), of length 1 or 0."""
    first, second, third = spots[0::3], spots[1::3], spots[2::3]
    normals = np.cross(second - first, third - first)
    lengths = np.linalg.norm(normals, axis=1, keepdims=True)
    return np.repeat(normals / np.where(lengths > 0, lengths, 1.0), 3, axis=0)


# -- polygons ------------------------------------------------------------------------------------------------


def _indices(primitive: Element, width: int) -> tuple[Integers, Integers]:
    """Return how many corners each polygon, strip or fan has, and the indices (corners, width) of all."""
    lists = [integers(each) for each in primitive.findall('p')]
    lists += [integers(each) for hollow in primitive.findall('ph') for each in hollow.findall('p')]
    if any(len(each) % width for each in lists):
        raise ColladaError(
            f'<{primitive.tag}> of line {primitive.line} does not have {width} indices for each corner'
        )
    indices = np.concatenate([np.empty(0, np.int64), *lists]).reshape(-1, width)
    if primitive.tag == 'triangles':
        return np.full(len(indices) // 3, 3), indices[: len(indices) // 3 * 3]
    if primitive.tag != 'polylist':
        return np.array([len(each) // width for each in lists], np.int64), indices
    counts = primitive.find('vcount')
    if counts is None:
        return np.empty(0, np.int64), indices
    sizes = integers(counts)
    if (sizes < 0).any() or (sizes > len(indices)).any() or sizes.sum() > len(indices):
        raise ColladaError(f'<vcount> of line {counts.line} counts more corners than there are')
    return sizes, indices[: sizes.sum()]


def _triangles(tag: str, sizes: Integers, spots: Floats) -> Integers:
    if tag == 'tristrips':
        return triangles_of_strips(sizes)
    if tag == 'trifans':
        return triangles_of_fans(sizes)
    return triangles_of_polygons(sizes, spots)


def _shared(columns: list[Integers], triangles: Integers) -> tuple[Integers, Integers]:
    """Return which corners differ from all before them, and the triangles by numbers of these."""
    keys = np.zeros(len(columns[0]), np.int64)
    for column in columns:
        _, keys = np.unique(keys * (int(column.max()) + 1) + column, return_inverse=True)
    used = keys[triangles.reshape(-1)]
    _, kept, numbers = np.unique(used, return_index=True, return_inverse=True)
    return triangles.reshape(-1)[kept], numbers.reshape(-1, 3)
