"""Frames and layouts in a real browser: axes, the fixed frame, and what a reload and a file keep."""

from __future__ import annotations

import json
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import pytest
from helpers.console import PROGRAMS, Stage, picture
from helpers.page import choose, row, until, view
from helpers.patience import wait_for

OpenPage = Callable[[str], Any]

pytestmark = [pytest.mark.slow, pytest.mark.timeout(400)]

# The colour of the pixel that shows a point of the floor.
COLOUR = """([x, y]) => {
  const scene = goalwireScene, box = scene.renderer.domElement.getBoundingClientRect();
  scene.renderer.render(scene.scene, scene.camera);
  const gl = scene.renderer.getContext(), pixel = new Uint8Array(4), [left, top] = scene.screen_of(x, y, 0);
  gl.readPixels((left - box.left) / box.width * gl.drawingBufferWidth,
    (1 - (top - box.top) / box.height) * gl.drawingBufferHeight, 1, 1, gl.RGBA, gl.UNSIGNED_BYTE, pixel);
  return [...pixel].slice(0, 3);
}"""
PLOTTED = """() => getElement(document.querySelector('[data-plot]').id.slice(1))
    .chart.getOption().series[0]?.data.length > 3"""
SPOTS = '() => goalwireScene.axes.spots()'


@pytest.fixture(autouse=True)
def nothing_left_behind() -> None:
    """The browser's driver keeps threads of its own until the module's end; consoles are processes."""


@pytest.fixture(scope='module')
def surveyed() -> Iterator[str]:
    """The address of a console beside a robot and its surveyor; each tab has a layout of its own."""
    pytest.importorskip('nicegui')
    stage = Stage('rmw_zenoh_cpp')
    stage.robot()
    stage.program(PROGRAMS / 'surveyor.py').expect('ready')
    yield stage.console()[1]
    stage.close()


def rounded(page: Any, frame: str) -> list[float]:
    """Where a frame is in the scene."""
    return [round(number, 2) + 0.0 for number in page.evaluate(SPOTS)[frame]]


def test_frames_have_axes_and_one_of_them_stands_still(surveyed: str, open_page: OpenPage) -> None:
    page = open_page(f'{surveyed}?view=robot')
    page.wait_for_selector('[data-frames-note]:has-text("frames")')
    until(page, '() => goalwireScene.links.size > 0')
    assert page.evaluate(SPOTS) == {}
    wait_for(lambda: page.evaluate(COLOUR, [-0.9, 0.0])[2] > 150, 'the floor where no axes are')
    page.click('[data-axes]')
    until(page, '() => goalwireScene.axes.spots().map !== undefined')
    assert rounded(page, 'map') == [-1.0, 0.0, 0.0]
    for name in ('map', 'odom', 'world'):
        page.wait_for_selector(f'.gw-axes-name:text-is("{name}")')

    # The x axis of `map` is red, and its y axis is green.
    def colour_is(place: list[float], strongest: int) -> bool:
        colour = page.evaluate(COLOUR, place)
        return bool(colour.index(max(colour)) == strongest and max(colour) - sorted(colour)[1] > 60)

    wait_for(lambda: colour_is([-0.9, 0.0], 0), 'a red pixel')
    wait_for(lambda: colour_is([-1.0, 0.1], 1), 'a green pixel')

    # The fixed frame stands still: everything else is placed in it, and the floor is still the world's.
    page.wait_for_selector('[data-layer-note="/map"]:has-text("20 x 20 cells")')
    choose(page, '[data-fixed-frame]', 'map')
    until(page, '() => Math.abs(goalwireScene.axes.spots().world[0] - 1) < 0.01')
    assert rounded(page, 'map') == [0.0, 0.0, 0.0]
    assert page.evaluate("() => goalwireScene.layers.spots('/map')")[0][1:] == pytest.approx([0.0, -2.0, 0.0])
    # In one step, for the camera may still glide after the robot.
    place = page.evaluate('() => goalwireScene.floor_at(...goalwireScene.screen_of(0.5, 0.4)).toArray()')
    assert place == pytest.approx([0.5, 0.4, 0.0], abs=0.01)

    # The tree has the frames below their parents, and those that nothing joins.
    page.click('[data-frame-tree]')
    tree = page.locator('[data-frames] .q-tree')
    assert tree.locator('> .q-tree__node:has-text("world") .q-tree__node:has-text("odom")').count() >= 1
    tree.locator('.q-tree__node-header:has-text("odom") .q-checkbox').first.click()
    until(page, '() => goalwireScene.axes.spots().odom === undefined')
    picture(page, 'frames')
    page.click('[data-axis-names]')
    until(
        page, "() => [...document.querySelectorAll('.gw-axes-name')].every(e => e.style.display === 'none')"
    )


def test_a_layout_survives_a_reload_and_goes_to_a_file(
    surveyed: str, open_page: OpenPage, tmp_path: Path
) -> None:
    page = open_page(f'{surveyed}?view=robot')
    until(page, "() => window.goalwireScene?.layers?.spots('/markers').length > 0")
    page.click('[data-axes]')
    page.click('[data-layer="/markers"]')
    choose(page, '[data-fixed-frame]', 'odom')
    page.click('.gw-scene-bar button:has-text("vertical_align_bottom")')
    until(page, "() => JSON.parse(sessionStorage.getItem('goalwire-layout'))?.camera.length === 6")
    view(page, 'topics')
    row(page, '/load')
    page.click('.gw-plot-button')
    page.wait_for_selector('[data-series]:has-text("/load data")')
    until(page, PLOTTED)

    # Another view leaves the plot as it was, with its values.
    view(page, 'logs')
    view(page, 'topics')
    page.wait_for_selector('[data-series]:has-text("/load data")')
    until(page, PLOTTED)

    def is_as_before() -> None:
        page.wait_for_selector('[data-series]:has-text("/load data")')
        page.wait_for_selector('.gw-title:text-is("/load")')
        view(page, 'robot')
        until(page, '() => window.goalwireScene?.axes?.spots().odom !== undefined')
        assert page.locator('[data-layer="/markers"][aria-checked="false"]').is_visible()
        high, target = page.evaluate(
            '() => [goalwireScene.camera.position.z, goalwireScene.controls.target.z]'
        )
        assert high - target > 2
        assert page.evaluate("() => goalwireScene.layers.spots('/markers')") == []

    page.reload()
    is_as_before()
    picture(page, 'layout-kept')
    view(page, 'topics')
    page.click('[data-layout]')
    with page.expect_download() as saved:
        page.click('[data-layout-save]')
    file = tmp_path / 'mine.json'
    saved.value.save_as(file)
    assert json.loads(file.read_text())['plots'] == [['/load', 'data']]

    # Another tab begins with the standard layout, until it loads the file.
    other = page = open_page(f'{surveyed}?view=robot')
    other.wait_for_selector('[data-layer="/markers"][aria-checked="true"]')

    def load(chosen: Path) -> None:
        other.click('[data-layout]')
        with other.expect_file_chooser() as chooser:
            other.click('[data-layout-load]')
        chooser.value.set_files(chosen)

    wrong = tmp_path / 'wrong.json'
    wrong.write_text('{"goalwire_layout": 1, "plots": "all"}')
    load(wrong)
    other.wait_for_selector("text=its value 'plots' is not valid")
    load(file)
    is_as_before()


def test_other_robots_are_drawn_beside_the_selected_one(stage: Stage, open_page: OpenPage) -> None:
    stage.program(PROGRAMS / 'pair.py').expect('ready')
    _, url = stage.console()
    page = open_page(f'{url}?view=robot&robot=/alice')
    until(page, "() => window.goalwireScene?.others?.get('/bob')?.group.visible")

    def is_red(place: list[float]) -> bool:
        red, green, _ = page.evaluate(COLOUR, place)
        return bool(red - green > 60)

    # A robot whose frame nothing joins is named, and not drawn.
    page.wait_for_selector('[data-other-robot-note="/carol"]:has-text("attic")')
    wait_for(lambda: is_red([1.5, -0.3]), 'a red pixel of bob')
    assert not page.evaluate("() => goalwireScene.others.get('/carol').group.visible")
    page.wait_for_selector('.gw-scene-label:text-is("/bob")')
    picture(page, 'several-robots')

    # The page belongs to alice all the same, and what is switched off is gone, also after a reload.
    assert page.locator('.gw-robot:has-text("/alice")').is_visible()
    page.click('[data-other-robot="/bob"]')
    until(page, "() => goalwireScene.others.get('/bob') === undefined")
    wait_for(lambda: not is_red([1.5, -0.3]), 'a floor without bob')
    page.reload()
    page.wait_for_selector('[data-other-robot="/bob"][aria-checked="false"]')
    until(page, '() => window.goalwireScene?.others?.size === 1')
    page.click('[data-other-robot="/bob"]')
    until(page, "() => goalwireScene.others.get('/bob')?.group.visible")
