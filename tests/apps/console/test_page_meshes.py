"""A robot of COLLADA files in a real browser: in their size and colours, and what stands for a broken one."""

from __future__ import annotations

import json
import struct
import zlib
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
from helpers.console import PROGRAMS, Stage, picture
from helpers.meshes import collada_box, share_folder
from helpers.page import until

OpenPage = Callable[[str], Any]

pytestmark = [pytest.mark.slow, pytest.mark.timeout(400)]

_VISUAL = """<visual><origin xyz="{x} 0 0.5"/><geometry><mesh filename="package://arm/{name}.dae"/></geometry>
    <material name="{name}"><color rgba="0 1 0 {alpha}"/></material></visual>"""
URDF = f"""<robot name="arm"><link name="base_link">{_VISUAL.format(x=0, name='orange', alpha=0.5)}
    {_VISUAL.format(x=1, name='pictured', alpha=1)}{_VISUAL.format(x=2, name='plain', alpha=1)}</link>
  <link name="hand">{_VISUAL.format(x=3, name='broken', alpha=1)}
    <collision><geometry><sphere radius="0.2"/></geometry></collision></link>
  <joint name="wrist" type="fixed"><parent link="base_link"/><child link="hand"/></joint></robot>"""
# Of each mesh of a link: its size, the colour and opacity, and whether it has a picture.
MESHES = """link => {
  const found = [];
  goalwireScene.links.get(link)?.group.traverse(each => {
    if (!each.isMesh) return;
    each.geometry.computeBoundingBox();
    const { min, max } = each.geometry.boundingBox, { color, opacity, map } = each.material;
    const size = ['x', 'y', 'z'].map(axis => Math.round((max[axis] - min[axis]) * 1000) / 1000);
    found.push([size, color.getHexString(), opacity, map?.image?.width ?? 0]);
  });
  return found.sort();
}"""


@pytest.fixture(autouse=True)
def nothing_left_behind() -> None:
    """The browser's driver keeps threads of its own until the module's end; consoles are processes."""


def png(width: int, height: int) -> bytes:
    """A picture in one colour."""

    def part(kind: bytes, data: bytes) -> bytes:
        return struct.pack('>I', len(data)) + kind + data + struct.pack('>I', zlib.crc32(kind + data))

    rows = (b'\0' + b'\x20\x60\xe0' * width) * height
    head = part(b'IHDR', struct.pack('>IIBBBBB', width, height, 8, 2, 0, 0, 0))
    return b'\x89PNG\r\n\x1a\n' + head + part(b'IDAT', zlib.compress(rows)) + part(b'IEND', b'')


def until_drawn(page: Any, link: str, *meshes: list[Any]) -> None:
    """Wait until a link has these meshes, in the form of MESHES.

    A page draws its robot a second time, mesh by mesh, if a file turned out to be broken.
    """
    wanted = json.dumps(meshes, separators=(',', ':'))
    until(page, f"() => window.goalwireScene?.links && JSON.stringify(({MESHES})('{link}')) === '{wanted}'")


def test_meshes_in_collada_are_shown(stage: Stage, open_page: OpenPage, tmp_path: Path) -> None:
    stage.env['AMENT_PREFIX_PATH'] = str(tmp_path)
    share = share_folder(tmp_path, 'arm')
    (share / 'skin.png').write_bytes(png(8, 8))
    (share / 'orange.dae').write_text(collada_box(0.2, 0.3, 0.4), encoding='utf-8')
    (share / 'pictured.dae').write_text(collada_box(0.5, 0.5, 0.6, picture='skin.png'), encoding='utf-8')
    (share / 'plain.dae').write_text(collada_box(0.1, 0.1, 0.1, picture='none.png'), encoding='utf-8')
    broken = collada_box(1, 1, 1).replace('4 4 4', '4 4 9')
    (share / 'broken.dae').write_text(broken, encoding='utf-8')
    (tmp_path / 'arm.urdf').write_text(URDF, encoding='utf-8')
    stage.program(PROGRAMS / 'robot.py', str(tmp_path / 'arm.urdf')).expect('ready')
    page = open_page(f'{stage.console()[1]}?view=robot')

    # Their sizes are in m whatever the unit, y stays y, and the URDF has its opacity.
    until_drawn(
        page,
        'base_link',
        [[0.1, 0.1, 0.1], '00ff00', 1, 0],
        [[0.2, 0.3, 0.4], 'ff8000', 0.5, 0],
        [[0.5, 0.5, 0.6], 'ffffff', 1, 8],
    )

    # One line says what is wrong with a file, and the link's shape for collisions stands for it.
    page.wait_for_selector('[data-robot-problem]:has-text("broken.dae")')
    line = broken[: broken.index('<vcount>')].count('\n') + 1
    problem = f'<vcount> of line {line} counts more corners than there are'
    assert page.inner_text('[data-robot-problem]') == f"'package://arm/broken.dae' cannot be shown: {problem}"
    sizes = f"({MESHES})('hand').map(([size]) => size)"
    until(page, f"() => JSON.stringify({sizes}) === '[[0.4,0.4,0.4]]'")
    page.wait_for_selector('text=1 meshes are not shown')
    picture(page, 'collada')
