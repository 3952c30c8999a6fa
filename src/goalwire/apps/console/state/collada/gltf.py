"""Writes surfaces as a binary glTF file (.glb), version 2.0.

See https://registry.khronos.org/glTF/specs/2.0/glTF-2.0.html.
"""

from __future__ import annotations

import json
import struct
from collections.abc import Iterable
from typing import Any

import numpy as np

from goalwire.apps.console.state.collada.materials import Material, Rgb
from goalwire.apps.console.state.collada.reader import Surface

_FLOAT, _UNSIGNED_INT = 5126, 5125
_VERTICES, _INDICES = 34962, 34963
_ROUGHNESS, _METALNESS = 0.55, 0.08
"""Those of the shapes in the page's scene (shapes.js)."""


def write_gltf(surfaces: Iterable[Surface]) -> bytes:
    """Return a file with one mesh. Surfaces without a material have none there."""
    writer = _Writer()
    for surface in surfaces:
        writer.add(surface)
    return writer.file()


class _Writer:
    """The parts of a file in the making."""

    def __init__(self) -> None:
        self._data: list[bytes] = []
        self._length = 0
        self._views: list[dict[str, Any]] = []
        self._accessors: list[dict[str, Any]] = []
        self._primitives: list[dict[str, Any]] = []
        self._materials: list[dict[str, Any]] = []
        self._pictures: list[str] = []

    def add(self, surface: Surface) -> None:
        """Append a surface."""
        limits = {'min': surface.spots.min(axis=0).tolist(), 'max': surface.spots.max(axis=0).tolist()}
        attributes = {
            'POSITION': self._accessor(surface.spots, 'VEC3', _VERTICES, **limits),
            'NORMAL': self._accessor(surface.normals, 'VEC3', _VERTICES),
        }
        if surface.picture_spots is not None:  # glTF counts from the picture's upper left
            spots = surface.picture_spots * np.array([1, -1], np.float32) + np.array([0, 1], np.float32)
            attributes['TEXCOORD_0'] = self._accessor(spots, 'VEC2', _VERTICES)
        corners = self._accessor(surface.triangles.reshape(-1), 'SCALAR', _INDICES)
        primitive: dict[str, Any] = {'attributes': attributes, 'indices': corners}
        if surface.material is not None:
            primitive['material'] = len(self._materials)
            self._materials.append(self._material(surface.material, f'material {len(self._materials)}'))
        self._primitives.append(primitive)

    def _accessor(self, values: np.ndarray[Any, Any], kind: str, target: int, **limits: Any) -> int:
        data = values.astype(values.dtype.newbyteorder('<')).tobytes()
        view = {'buffer': 0, 'byteOffset': self._length, 'byteLength': len(data), 'target': target}
        component = _FLOAT if target == _VERTICES else _UNSIGNED_INT
        accessor = {'bufferView': len(self._views), 'componentType': component, 'count': len(values)}
        self._accessors.append({**accessor, 'type': kind, **limits})
        self._views.append(view)
        self._data.append(data)
        self._length += len(data)
        return len(self._accessors) - 1

    def _material(self, material: Material, name: str) -> dict[str, Any]:
        surface: dict[str, Any] = {
            'baseColorFactor': [*_linear(material.rgb), 1.0],
            'metallicFactor': _METALNESS,
            'roughnessFactor': _ROUGHNESS,
        }
        if material.picture:
            if material.picture not in self._pictures:
                self._pictures.append(material.picture)
            surface['baseColorTexture'] = {'index': self._pictures.index(material.picture)}
        return {'name': name, 'pbrMetallicRoughness': surface, 'emissiveFactor': _linear(material.glow)}

    def file(self) -> bytes:
        """Return the file's bytes."""
        head: dict[str, Any] = {
            'asset': {'version': '2.0'},
            'scene': 0,
            'scenes': [{'nodes': [0]}],
            'nodes': [{'mesh': 0}],
            'meshes': [{'primitives': self._primitives}],
            'accessors': self._accessors,
            'bufferViews': self._views,
            'buffers': [{'byteLength': self._length}],
        }
        if self._materials:
            head['materials'] = self._materials
        if self._pictures:
            head['images'] = [{'uri': address} for address in self._pictures]
            head['textures'] = [{'source': number} for number in range(len(self._pictures))]
        text = json.dumps(head, allow_nan=False, separators=(',', ':')).encode()
        text += b' ' * (-len(text) % 4)
        data = b''.join(self._data)  # whole words, each of four bytes
        chunks = (
            struct.pack('<I4s', len(text), b'JSON') + text + struct.pack('<I4s', len(data), b'BIN\0') + data
        )
        return struct.pack('<4sII', b'glTF', 2, 12 + len(chunks)) + chunks


def _linear(rgb: Rgb) -> list[float]:
    """Return a colour as glTF has it: proportional to light, where a screen's values are not."""
    return [part / 12.92 if part <= 0.04045 else ((part + 0.055) / 1.055) ** 2.4 for part in rgb]
