"""Layers of the 3D view in a real browser: maps, scans, points and their like stand where the data says."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

import pytest
from helpers.console import PROGRAMS, Stage, picture
from helpers.page import until, view
from helpers.patience import wait_for

OpenPage = Callable[[str], Any]

pytestmark = [pytest.mark.slow, pytest.mark.timeout(400)]

# Red, green and blue of the pixels that show these points of the scene, all in one drawing.
COLOURS = """spots => {
  const scene = goalwireScene, box = scene.renderer.domElement.getBoundingClientRect();
  scene.renderer.render(scene.scene, scene.camera);
  const gl = scene.renderer.getContext(), pixel = new Uint8Array(4);
  return spots.map((spot) => {
    const [left, top] = scene.screen_of(...spot);
    gl.readPixels((left - box.left) / box.width * gl.drawingBufferWidth,
      (1 - (top - box.top) / box.height) * gl.drawingBufferHeight, 1, 1, gl.RGBA, gl.UNSIGNED_BYTE, pixel);
    return [...pixel.slice(0, 3)];
  });
}"""
# The opacities of the markers, a cube and a cylinder, as they are drawn for an eye that looks at a spot.
OPACITIES = """([eye, spot]) => {
  const point = goalwireScene.controls.target, layers = goalwireScene.layers;
  layers.veil(point.clone().set(...eye), point.clone().set(...spot));
  return [...layers.groups.get('/markers').values()].flatMap(
    (group) => group.children.map(({ open, veils }) => {
      const drawn = [open, ...veils.values()].filter((each) => each.visible);
      return drawn.length === 1 && drawn[0].material.opacity;
    }));
}"""
# Whether a cloud that comes anew, and is drawn each time, is drawn with the same shaders.
KEEPS_SHADERS = """() => {
  const scene = goalwireScene, cloud = { kind: 'cloud', spots: 'A'.repeat(16), colours: 'AAAA' };
  const shaders = [1, 2, 3].map(() => {
    scene.layers.put('/again', { map: [cloud] });
    scene.layers.place('/again', { map: [0, 0, 0, 0, 0, 0, 1] });
    scene.renderer.render(scene.scene, scene.camera);
    scene.layers.frame_drawn();
    return scene.renderer.info.programs.map((each) => each.id).join();
  });
  scene.layers.put('/again', null);
  scene.wake();
  return new Set(shaders).size === 1;
}"""
LOAD = """async url => {
  const { mesh_of } = await import('goalwire-scene-layers');
  window.loaded = mesh_of({ kind: 'mesh', url, size: [1, 1, 1], rgba: [1, 1, 1, 1] }, () => undefined);
}"""
# Each triangle's corners and its first normal, once the mesh is there.
TRIANGLES = """() => {
  if (!loaded.children.length) return null;
  const { position, normal } = loaded.children[0].geometry.attributes, found = [];
  for (let at = 0; at < position.count; at += 3)
    found.push([...position.array.slice(3 * at, 3 * at + 9), ...normal.array.slice(3 * at, 3 * at + 3)]);
  return found;
}"""
# The points of a cloud, and the triangles and heights of 100 markers and of a mesh: in full and coarsely.
COARSELY = """async (url) => {
  const { Layers, draw_coarsely, mesh_of } = await import('goalwire-scene-layers');
  const layers = new Layers(), bytes = (count) => btoa(String.fromCharCode(...new Uint8Array(count)));
  const spheres = [...Array(100).keys()].map((at) => (
    { kind: 'sphere', rgba: [1, 0, 0, 1], size: [0.1, 0.1, 0.1], pose: [at, 0, 0, 0, 0, 0, 1] }));
  const cloud = { kind: 'cloud', spots: bytes(12 * 1001), colours: bytes(3 * 1001) };
  layers.put('/some', { map: [cloud, ...spheres] });
  await new Promise((done) => {
    const mesh = mesh_of({ kind: 'mesh', url, size: [1, 1, 1], rgba: [1, 1, 1, 1] }, done);
    layers.root.add(mesh);
  });
  const copies = () => {
    let count = 0;
    layers.root.traverse((each) => (count += each.copies ? 1 : 0));
    return count;
  };
  draw_coarsely(layers.root, false);
  const early = copies();
  return [early, ...[false, true, false].map((coarsely) => {
    draw_coarsely(layers.root, coarsely);
    const found = [];
    layers.root.traverse((each) => {
      if (!each.geometry) return;
      const { index, attributes } = each.geometry, corners = index ? index.count : attributes.position.count;
      each.geometry.computeBoundingBox();
      const { min, max } = each.geometry.boundingBox;
      const triangles = corners / 3 * (each.isInstancedMesh ? each.count : 1);
      found.push(each.isPoints ? [corners, 0] : [triangles, max.z - min.z]);
    });
    return found;
  })];
}"""
# One step of detail is taken away by a late frame, or comes back.
STEP = """([level, is_late]) => {
  const scene = goalwireScene, now = performance.now();
  Object.assign(scene.detail, { level, slow: is_late ? 8 : 0, strained: -1e6, patience: 1e4 });
  scene.asked = is_late ? now - 500 : now;
  scene.rendered = now - 5000;
  scene.adapt(now);
}"""
# The level of detail after frames that came so many ms late, one each 100 ms.
DETAIL = """async groups => {
  const { Detail } = await import('goalwire-scene-layers');
  const detail = new Detail(), levels = [];
  let now = 1000;
  for (const [count, late] of groups) {
    for (let frame = 0; frame < count; frame++) detail.note(late, now += 100);
    levels.push(detail.level);
  }
  return levels;
}"""
SQUARE = """# a square, with its corners counted from the front and from the back
v 0 0 0
v 1 0 0 0.5 0.5 0.5
v 1 1 0
v 0 1 0
f 1/1 2//7 -2 \\
  -1/4
"""
NORMAL_GIVEN = 'v 0 0 0\r\nv 1 0 0\r\nv 0 1 0\r\nvn 0 1 0\r\nf 1//1 2//1 3//1\r\n'


def ball() -> str:
    """A ball of 1 m as an OBJ, with 20 rings of 40 squares each."""
    lines = []
    for down in range(21):
        for around in range(40):
            height, turn = math.pi * down / 20, math.tau * around / 40
            x, y = math.sin(height) * math.cos(turn) / 2, math.sin(height) * math.sin(turn) / 2
            lines.append(f'v {x:.5f} {y:.5f} {math.cos(height) / 2:.5f}')
    for ring in range(20):
        for at in range(40):
            above, beside = 40 * ring + 1, (at + 1) % 40
            lines.append(f'f {above + at} {above + 40 + at} {above + 40 + beside} {above + beside}')
    return '\n'.join(lines)


def load(page: Any, url: str) -> Any:
    """Load a mesh; return its triangles."""
    page.evaluate(LOAD, url)
    return until(page, TRIANGLES)


def brightness(page: Any, *spots: tuple[float, ...]) -> list[float]:
    """The brightness of the pixels that show these points, from 0 to 255."""
    return [sum(colour) / 3 for colour in page.evaluate(COLOURS, spots)]


@pytest.fixture(autouse=True)
def nothing_left_behind() -> None:
    """The browser's driver keeps threads of its own until the module's end; consoles are processes."""


def switch(page: Any, topic: str) -> None:
    """Turn a layer on or off."""
    page.click(f'[data-layer="{topic}"]')


def test_layers_stand_where_the_data_says(stage: Stage, open_page: OpenPage) -> None:
    stage.robot()
    stage.program(PROGRAMS / 'surveyor.py').expect('ready')
    _, url = stage.console()
    page = open_page(f'{url}?view=robot')

    def spots(topic: str) -> list[list[Any]]:
        found: list[list[Any]] = page.evaluate('(topic) => goalwireScene.layers.spots(topic)', topic)
        return [[each[0], *(round(number, 2) for number in each[1:])] for each in found]

    # Each is shifted by the transform of its frame, (-1, 0).
    for topic in ('/map', '/scan', '/markers', '/plan'):
        until(page, '(topic) => window.goalwireScene?.layers?.spots(topic).length > 0', topic)
    assert spots('/map') == [['Mesh', -1.0, -2.0, 0.0]]
    assert spots('/scan') == [['Points', 1.0, 0.0, 0.0]]
    assert spots('/markers') == [['Mesh', 1.0, 0.0, 0.5], ['Mesh', 2.0, 0.0, 0.5]]
    line, arrow = spots('/plan')
    assert line == ['Mesh', 0.5, -1.0, 0.0]
    assert arrow[1:] == pytest.approx([1.17, -1.0, 0.02], abs=0.01), 'from the last pose along its x axis'
    page.wait_for_selector('[data-layer-note="/map"]:has-text("20 x 20 cells")')
    page.wait_for_selector('[data-layer-note="/scan"]:has-text("1 point")')

    # Layers come anew many times a second, and to compile a shader takes many milliseconds.
    assert page.evaluate(KEEPS_SHADERS)
    until(page, '() => goalwireScene.layers.gone.size === 0')

    # A cloud is large, so it is off until somebody wants it.
    assert spots('/points') == []
    switch(page, '/points')
    until(page, "() => goalwireScene.layers.spots('/points').length > 0")
    assert spots('/points') == [['Points', 1.0, 1.0, 0.5]]
    page.wait_for_selector('[data-layer-note="/points"]:has-text("2 points")')
    page.wait_for_selector('[data-layer-note="/camera_info"]:has-text("160 x 120 pixels")')
    page.wait_for_selector('[data-layer-note="/amcl_pose"]:has-text("±0.40 m")')
    assert [len(spots(topic)) for topic in ('/camera_info', '/amcl_pose')] == [1, 2]

    # A frame that nothing joins to the robot's is named, and its layer not drawn.
    page.wait_for_selector('[data-layer-note="/stray_scan"]:has-text("nowhere")')
    assert spots('/stray_scan') == []

    # Meshes in OBJ become triangles, with normals of their own if the file has none.
    page.route('**/square.obj', lambda route: route.fulfill(body=SQUARE))
    page.route('**/given.obj', lambda route: route.fulfill(body=NORMAL_GIVEN))
    flat = [0, 0, 1]
    assert load(page, '/square.obj') == [
        [0, 0, 0, 1, 0, 0, 1, 1, 0, *flat],
        [0, 0, 0, 1, 1, 0, 0, 1, 0, *flat],
    ]
    assert load(page, '/given.obj') == [[0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 1, 0]]

    # A slow computer draws a quarter of a cloud's points, and meshes and balls with a few triangles.
    page.route('**/ball.obj', lambda route: route.fulfill(body=ball()))
    copies, full, coarse, full_again = page.evaluate(COARSELY, '/ball.obj')
    assert copies == 0, 'a computer that draws all of it makes no coarse copies'
    assert full == full_again
    assert [number for number, _ in full] == [1001, 100 * 352, 1600]
    assert [number for number, _ in coarse[:2]] == [251, 100 * 80]
    assert 200 < coarse[2][0] < 900
    assert coarse[2][1] == pytest.approx(1.0, abs=0.1)

    page.evaluate(STEP, [2, False])
    assert not page.is_visible('.gw-scene-coarse')
    page.evaluate(STEP, [1, True])
    assert page.is_visible('.gw-scene-coarse:has-text("less detail")')

    # Eight late frames take a step of detail away. It comes back after ten seconds, and after twenty if the
    # computer was too slow for it again. Seven late frames, and then some in time, take nothing away.
    late, in_time = 100, 0
    frames = [(8, late), (8, late), (99, in_time), (1, in_time), (8, late), (199, in_time), (1, in_time)]
    assert page.evaluate(DETAIL, frames) == [1, 2, 2, 1, 2, 2, 1]
    assert page.evaluate(DETAIL, [(7, late), (28, in_time), (7, late)]) == [0, 0, 0]

    # A camera's picture hangs at the end of what it sees: here 0.4 m above the map's origin.
    assert page.locator('[data-layer="/elsewhere/image_raw"]').count() == 0, (
        'there is no camera_info beside it'
    )
    switch(page, '/image_raw')
    until(page, "() => goalwireScene.layers.spots('/image_raw').length === 1")
    page.wait_for_selector('[data-layer-note="/image_raw"]:has-text("4 x 2 pixels")')
    inside = [(-0.9, 0.1, 0.4)]
    wait_for(lambda: page.evaluate(COLOURS, inside)[0][1] < 60, 'the red picture')
    assert page.evaluate(COLOURS, inside)[0][0] > 150

    # The cube of the markers is seen through as long as it stands between the eye and what the view looks at.
    assert page.evaluate(OPACITIES, [[1.0, -2.0, 0.5], [1.0, 2.0, 0.5]]) == pytest.approx([0.15, 1.0])
    assert page.evaluate(OPACITIES, [[1.0, -2.0, 0.5], [1.0, -1.0, 0.5]]) == [1.0, 1.0], 'it stands behind'
    assert page.evaluate(OPACITIES, [[1.0, 0.0, 0.5], [1.0, 2.0, 0.5]]) == pytest.approx([0.15, 1.0]), (
        'inside'
    )

    # A layer that is switched off is gone.
    picture(page, 'layers')
    switch(page, '/markers')
    until(page, "() => goalwireScene.layers.spots('/markers').length === 0")

    # The wall is dark, and the floor beside it and where its mirror images would be is bright.
    wall, others = (0.7, 0.9, 0.0), ((0.3, 0.9, 0.0), (1.3, 0.5, 0.0), (0.7, -0.6, 0.0))
    wait_for(lambda: brightness(page, wall)[0] < 80, 'a dark pixel of the wall')
    assert min(brightness(page, *others)) > 150
    switch(page, '/map')
    until(page, "() => goalwireScene.layers.spots('/map').length === 0")
    wait_for(lambda: brightness(page, wall)[0] > 150, 'a floor without the wall')
    assert 'Subscription count: 0' in stage.command('ros2 topic info /map')
    switch(page, '/map')
    until(page, "() => goalwireScene.layers.spots('/map').length === 1")

    # Nobody looks: nothing is subscribed to.
    assert 'Subscription count: 1' in stage.command('ros2 topic info /scan')
    view(page, 'logs')
    for topic in ('/scan', '/map', '/plan'):
        assert 'Subscription count: 0' in stage.command(f'ros2 topic info {topic}')
