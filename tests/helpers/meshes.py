"""Mesh files, and packages that they are installed in."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path


def share_folder(prefix: Path, package: str) -> Path:
    """Install an empty package below a prefix, and return its share folder."""
    index = prefix / 'share' / 'ament_index' / 'resource_index' / 'packages'
    index.mkdir(parents=True, exist_ok=True)
    (index / package).touch()
    share = prefix / 'share' / package
    share.mkdir()
    return share


def collada_box(x: float, y: float, z: float, *, colour: str = '1 0.5 0', picture: str = '') -> str:
    """A box of this size in m around the origin, as a modelling program writes it: in cm, and with y up.

    A picture covers the whole of each side.
    """
    corners = [(a, b, c) for a in (-1, 1) for b in (-1, 1) for c in (-1, 1)]  # of 2 cm
    sides = [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)]
    normals = [(-1, 0, 0), (1, 0, 0), (0, -1, 0), (0, 1, 0), (0, 0, -1), (0, 0, 1)]
    indices = [
        f'{corner} {side} {place}' for side, each in enumerate(sides) for place, corner in enumerate(each)
    ]
    diffuse = '<texture texture="skin"/>' if picture else f'<color>{colour} 1</color>'
    return f"""<?xml version="1.0" encoding="utf-8"?>
<COLLADA xmlns="http://www.collada.org/2005/11/COLLADASchema" version="1.4.1">
  <asset><unit name="centimeter" meter="0.01"/><up_axis>Y_UP</up_axis></asset>
  <library_images><image id="skin"><init_from>{picture}</init_from></image></library_images>
  <library_effects><effect id="paint"><profile_COMMON><technique sid="common">
    <lambert><diffuse>{diffuse}</diffuse></lambert></technique></profile_COMMON></effect></library_effects>
  <library_materials><material id="red"><instance_effect url="#paint"/></material></library_materials>
  <library_geometries><geometry id="box"><mesh>
    {_source('places', corners)}{_source('sides', normals)}
    {_source('uv', [(0, 0), (1, 0), (1, 1), (0, 1)])}
    <vertices id="vertices"><input semantic="POSITION" source="#places"/></vertices>
    <polylist material="surface" count="6">
      <input semantic="VERTEX" source="#vertices" offset="0"/>
      <input semantic="NORMAL" source="#sides" offset="1"/>
      <input semantic="TEXCOORD" source="#uv" offset="2"/>
      <vcount>4 4 4 4 4 4</vcount><p>{' '.join(indices)}</p>
    </polylist></mesh></geometry></library_geometries>
  <library_visual_scenes><visual_scene id="scene"><node><scale>{50 * x} {50 * y} {50 * z}</scale>
    <instance_geometry url="#box"><bind_material><technique_common>
      <instance_material symbol="surface" target="#red"/>
    </technique_common></bind_material></instance_geometry>
  </node></visual_scene></library_visual_scenes>
  <scene><instance_visual_scene url="#scene"/></scene>
</COLLADA>"""


def _source(name: str, rows: Sequence[tuple[int, ...]]) -> str:
    numbers = ' '.join(str(number) for row in rows for number in row)
    names = ''.join(f'<param name="{axis}" type="float"/>' for axis in ('ST' if name == 'uv' else 'XYZ'))
    return f"""<source id="{name}"><float_array id="{name}-all">{numbers}</float_array><technique_common>
      <accessor source="#{name}-all" count="{len(rows)}" stride="{len(rows[0])}">{names}</accessor>
      </technique_common></source>"""
