"""COLLADA files as rviz shows them: what is read, how it becomes glTF, and what is refused with one line."""

from __future__ import annotations

import json
import struct
from collections.abc import Sequence
from typing import Any

import numpy as np
import pytest

from goalwire.apps.console.state.collada import document, reader
from goalwire.apps.console.state.collada.document import ColladaError
from goalwire.apps.console.state.collada.gltf import write_gltf
from goalwire.apps.console.state.collada.reader import Surface, read_collada

TRIANGLE = '0 0 0  1 0 0  0 1 0'
SQUARE = '0 0 0  1 0 0  1 1 0  0 1 0'
ONE = '<triangles><input semantic="VERTEX" source="#v" offset="0"/><p>0 1 2</p></triangles>'
USED = '<node><instance_geometry url="#g"/></node>'


def source(name: str, numbers: str, stride: int = 3) -> str:
    return f"""<source id="{name}"><float_array id="{name}-array">{numbers}</float_array>
        <technique_common><accessor source="#{name}-array" count="{len(numbers.split()) // stride}"
        stride="{stride}"/></technique_common></source>"""


def file(
    primitives: str = ONE,
    scene: str = USED,
    *,
    spots: str = TRIANGLE,
    asset: str = '',
    sources: str = '',
    libraries: str = '',
) -> bytes:
    """A file with one geometry, `g`, whose positions are `v`."""
    return f"""<?xml version="1.0" encoding="utf-8"?>
        <COLLADA xmlns="http://www.collada.org/2005/11/COLLADASchema" version="1.4.1"><asset>{asset}</asset>
        {libraries}<library_geometries><geometry id="g"><mesh>{source('s', spots)}{sources}
        <vertices id="v"><input semantic="POSITION" source="#s"/></vertices>{primitives}
        </mesh></geometry></library_geometries>
        <library_visual_scenes><visual_scene id="world">{scene}</visual_scene></library_visual_scenes>
        <scene><instance_visual_scene url="#world"/></scene></COLLADA>""".encode()


def corners(surface: Surface) -> list[list[list[float]]]:
    """Each triangle's corners, rounded."""
    spots = surface.spots.astype(np.float64)
    found: list[list[list[float]]] = (np.round(spots[surface.triangles], 3) + 0.0).tolist()
    return found


def area(surface: Surface) -> float:
    first, second, third = np.moveaxis(surface.spots[surface.triangles], 1, 0)
    return float(np.linalg.norm(np.cross(second - first, third - first), axis=1).sum() / 2)


# -- shapes --------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    'primitives',
    [
        '<triangles>{}<p>0 1 2 0 2 3</p></triangles>',
        '<polylist>{}<vcount>3 3</vcount><p>0 1 2 0 2 3</p></polylist>',
        '<polylist>{}<vcount>4</vcount><p>0 1 2 3</p></polylist>',
        '<polygons>{}<p>0 1 2</p><p>0 2 3</p></polygons>',
        '<polygons>{}<ph><p>0 1 2 3</p></ph></polygons>',
        '<trifans>{}<p>0 1 2 3</p></trifans>',
        '<tristrips>{}<p>1 2 0 3</p></tristrips>',
        '<triangles>{}<p>0 1 2</p></triangles><lines>{}<p>0 1</p></lines><trifans>{}<p>0 2 3</p></trifans>',
    ],
)
def test_polygons_strips_and_fans_become_triangles(primitives: str) -> None:
    given = primitives.replace('{}', '<input semantic="VERTEX" source="#v" offset="0"/>')
    [surface] = read_collada(file(given, spots=SQUARE))
    assert len(surface.triangles) == 2
    assert area(surface) == pytest.approx(1.0)
    assert surface.normals.tolist() == [[0, 0, 1]] * 6, 'all triangles run the same way round'


@pytest.mark.parametrize('order', [range(6), range(5, -1, -1), [2, 3, 4, 5, 0, 1], [4, 5, 0, 1, 2, 3]])
@pytest.mark.parametrize('axes', [(0, 1, 2), (2, 0, 1), (1, 2, 0)])
def test_a_concave_polygon_is_cut_along_its_inside(order: Sequence[int], axes: Sequence[int]) -> None:
    outline = np.array([[0, 0, 5], [3, 0, 5], [3, 1, 5], [1, 1, 5], [1, 3, 5], [0, 3, 5]])[list(order)][
        :, axes
    ]
    numbers = ' '.join(str(number) for number in outline.reshape(-1))
    ell = '<polylist><input semantic="VERTEX" source="#v"/><vcount>6</vcount><p>0 1 2 3 4 5</p></polylist>'
    [surface] = read_collada(file(ell, spots=numbers))
    assert len(surface.triangles) == 4
    assert area(surface) == pytest.approx(5.0), 'a fan from the wrong corner would cover 1 m² outside of it'


def test_corners_are_shared_only_if_their_normals_are_equal() -> None:
    normals = source('n', '0 0 1  0 1 0')
    inputs = (
        '<input semantic="VERTEX" source="#v" offset="0"/><input semantic="NORMAL" source="#n" offset="1"/>'
    )
    given = f'<triangles>{inputs}<p>0 0 1 0 2 0  0 0 2 0 3 1</p></triangles>'
    [surface] = read_collada(file(given, spots=SQUARE, sources=normals))
    assert len(surface.spots) == 4
    assert corners(surface)[1] == [[0, 0, 0], [1, 1, 0], [0, 1, 0]]
    assert surface.normals[surface.triangles[1]].tolist() == [[0, 0, 1], [0, 0, 1], [0, 1, 0]]


# -- the scene -----------------------------------------------------------------------------------------------


def test_lengths_become_metres_and_the_up_axis_does_not_turn() -> None:
    asset = '<unit name="inch" meter="0.0254"/><up_axis>{}_UP</up_axis>'
    files = [file(asset=asset.format(axis)) for axis in 'XYZ']
    assert [corners(read_collada(each)[0]) for each in files] == [
        [[[0, 0, 0], [0.025, 0, 0], [0, 0.025, 0]]]
    ] * 3


@pytest.mark.parametrize(
    ('transforms', 'second'),
    [
        ('<translate>1 2 3</translate>', [2, 2, 3]),
        ('<translate>1 2 3</translate><scale>2 1 1</scale>', [3, 2, 3]),
        ('<scale>2 1 1</scale><translate>1 2 3</translate>', [4, 2, 3]),
        ('<rotate>0 0 2 90</rotate>', [0, 1, 0]),
        ('<matrix>0 -1 0 7  1 0 0 8  0 0 1 9  0 0 0 1</matrix>', [7, 9, 9]),
        ('<rotate>0 0 0 90</rotate><lookat>0 0 0 1 0 0 0 1 0</lookat>', [1, 0, 0]),
    ],
)
def test_nodes_are_where_their_transforms_put_them(transforms: str, second: list[float]) -> None:
    inner = f'<node>{transforms}<instance_geometry url="#g"/></node>'
    for scene in (inner, f'<node>{inner}</node>'):
        assert corners(read_collada(file(scene=scene))[0])[0][1] == second


def test_geometries_are_used_as_often_as_the_scene_says() -> None:
    library = f'<library_nodes><node id="pair">{USED}<node><translate>0 0 1</translate>{USED}</node></node>'
    scene = '<node><instance_node url="#pair"/></node><node><instance_node url="#pair"/></node>'
    [surface] = read_collada(file(scene=scene, libraries=f'{library}</library_nodes>'))
    assert sorted(each[0][2] for each in corners(surface)) == [0, 0, 1, 1]
    skin = '<library_controllers><controller id="c"><skin source="#g"/></controller></library_controllers>'
    scene = '<node><instance_controller url="#c"/></node>'
    assert len(read_collada(file(scene=scene, libraries=skin))[0].triangles) == 1


def test_a_mirrored_node_still_shows_its_outside() -> None:
    [surface] = read_collada(file(scene=f'<node><scale>-1 2 1</scale>{USED}</node>'))
    assert surface.normals.tolist() == [[0, 0, 1]] * 3
    first, second, third = corners(surface)[0]
    assert np.cross(np.subtract(second, first), np.subtract(third, first))[2] > 0


# -- colours -------------------------------------------------------------------------------------------------

MATERIALS = """<library_images><image id="i"><init_from>skin.png</init_from></image></library_images>
    <library_materials><material id="m"><instance_effect url="#e"/></material></library_materials>
    <library_effects><effect id="e"><profile_COMMON>
    <newparam sid="surface"><surface type="2D"><init_from>i</init_from></surface></newparam>
    <newparam sid="sampler"><sampler2D><source>surface</source></sampler2D></newparam>
    <technique sid="common"><phong>{}</phong></technique></profile_COMMON></effect></library_effects>"""
BOUND = """<node><instance_geometry url="#g"><bind_material><technique_common>
    <instance_material symbol="paint" target="#m"/>
    </technique_common></bind_material></instance_geometry></node>"""
UV = ONE.replace('<p>', '<input semantic="TEXCOORD" source="#t" offset="0"/><p>').replace(
    '<triangles>', '<triangles material="paint">'
)


def painted(shader: str, kept: str = '/kept/') -> Surface:
    given = file(UV, BOUND, libraries=MATERIALS.format(shader), sources=source('t', '0 0  1 0  0 0.25', 2))
    [surface] = read_collada(given, lambda name: f'{kept}{name}' if kept else '')
    return surface


def test_a_surface_has_the_colour_of_its_material() -> None:
    red = '<emission><color>0 0 0.5 1</color></emission><diffuse><color sid="d">1 0.5 0 0.3</color></diffuse>'
    surface = painted(red + '<transparency><float>0</float></transparency>')
    assert surface.material is not None
    assert (surface.material.rgb, surface.material.glow) == ((1.0, 0.5, 0.0), (0.0, 0.0, 0.5))
    assert surface.picture_spots is None
    assert read_collada(file())[0].material is None, 'the colour of the URDF is taken'


def test_a_picture_is_put_on_a_surface() -> None:
    texture = '<diffuse><texture texture="sampler" texcoord="UVMap"/></diffuse>'
    surface = painted(texture)
    assert surface.material is not None
    assert (surface.material.rgb, surface.material.picture) == ((1.0, 1.0, 1.0), '/kept/skin.png')
    assert surface.picture_spots is not None
    assert surface.picture_spots[surface.triangles[0]].tolist() == [[0, 0], [1, 0], [0, 0.25]]
    assert painted(texture.replace('sampler', 'i')).material == surface.material, 'some files name the image'
    assert painted(texture, kept='').material is None, 'the picture is not there'


def test_surfaces_are_written_as_binary_gltf() -> None:
    data = write_gltf([painted('<diffuse><texture texture="i"/></diffuse>'), *read_collada(file())])
    magic, version, length, text_length, kind = struct.unpack_from('<4sII I4s', data)
    assert (magic, version, length, kind) == (b'glTF', 2, len(data), b'JSON')
    head: dict[str, Any] = json.loads(data[20 : 20 + text_length])
    assert head['images'] == [{'uri': '/kept/skin.png'}]
    first, second = head['meshes'][0]['primitives']
    assert (first['material'], 'material' in second) == (0, False)
    spots = head['accessors'][first['attributes']['POSITION']]
    assert (spots['count'], spots['min'], spots['max']) == (3, [0, 0, 0], [1, 1, 0])
    view = head['bufferViews'][head['accessors'][first['attributes']['TEXCOORD_0']]['bufferView']]
    body = data[28 + text_length :]
    picture_spots = np.frombuffer(body, '<f4', 6, view['byteOffset']).reshape(3, 2)
    assert sorted(picture_spots.tolist()) == [[0, 0.75], [0, 1], [1, 1]], 'counted from the upper left'
    assert head['buffers'] == [{'byteLength': len(body)}]


# -- what is refused -----------------------------------------------------------------------------------------

NESTED = '<library_nodes><node id="a"><instance_node url="#a"/></node></library_nodes>'


@pytest.mark.parametrize(
    ('data', 'problem'),
    [
        (b'', 'cannot be read as XML'),
        (b'solid hand', 'cannot be read as XML'),
        (file()[:-20], 'cannot be read as XML'),
        (b'<!DOCTYPE x [<!ENTITY a "aaa">]><COLLADA>&a;</COLLADA>', 'document type'),
        (b'<COLLADA>' + b'<a/>' * 1_000_000 + b'</COLLADA>', '256 MB of memory'),
        (b'<robot/>', 'begins with <robot>'),
        (b'<COLLADA/>', 'no scene'),
        (file(scene=''), 'no triangles'),
        (file('<triangles/>'), 'no positions'),
        (file(ONE.replace('0 1 2', '0 1 3')), 'position that is not there'),
        (file(ONE.replace('0 1 2', '0 1 -1')), 'position that is not there'),
        (file(ONE.replace('0 1 2', '0 1 x')), 'not a number'),
        (file(ONE.replace('0 1 2', '9' * 30)), 'not a number'),
        (file(ONE.replace('offset="0"', 'offset="4000000"')), 'above 31'),
        (file(ONE.replace('#v', '#w')), "refers to <vertices id='w'>"),
        (file(ONE.replace('#v', '#s')), "refers to <vertices id='s'>"),
        (
            file('<polylist><input semantic="VERTEX" source="#v"/><vcount>9</vcount><p>0 1</p></polylist>'),
            'than',
        ),
        (file(spots='0 0 nan 1 0 0 0 1 0'), 'not finite'),
        (file(spots='0 0 zero 1 0 0 0 1 0'), 'not a number'),
        (file(spots='0 0 1e200 1 0 0 0 1 0'), 'larger'),
        (file(asset='<unit meter="0"/>'), "unit is '0'"),
        (file(asset='<unit meter="one"/>'), "unit is 'one'"),
        (file(scene='<node><matrix>1 2 3</matrix></node>'), 'has 3 numbers, not 16'),
        (file(scene='<node><instance_node url="#a"/></node>', libraries=NESTED), 'contain themselves'),
        (file(scene='<node><instance_controller url="#g"/></node>'), 'refers to <controller'),
    ],
    ids=lambda given: given[:24] if isinstance(given, str) else '',
)
def test_a_file_that_cannot_be_shown_is_told_in_one_line(data: bytes, problem: str) -> None:
    with pytest.raises(ColladaError, match=problem) as caught:
        read_collada(data)
    assert '\n' not in str(caught.value)
    assert len(str(caught.value)) < 200


def test_what_a_small_file_asks_for_is_limited(monkeypatch: pytest.MonkeyPatch) -> None:
    many = ONE.replace('0 1 2', '0 1 2 ' * 100)
    monkeypatch.setattr(reader, 'MOST_TRIANGLES', 150)
    assert len(read_collada(file(many))[0].triangles) == 100
    with pytest.raises(ColladaError, match='more than 150 triangles'):
        read_collada(file(many, USED * 2))
    monkeypatch.setattr(document, 'MOST_SECONDS', 0.0)
    with pytest.raises(ColladaError, match='more than 0 s'):
        read_collada(file())
