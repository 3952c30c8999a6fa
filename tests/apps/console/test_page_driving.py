"""Presses in a real browser that move a robot: a pad that is held, and drags on the floor."""

from __future__ import annotations

import re
import signal
from collections.abc import Callable
from typing import Any

import pytest
from helpers.console import Stage, picture
from helpers.page import confirm, until
from helpers.patience import wait_for

OpenPage = Callable[[str], Any]

pytestmark = [pytest.mark.slow, pytest.mark.timeout(400)]


@pytest.fixture(autouse=True)
def nothing_left_behind() -> None:
    """The browser's driver keeps threads of its own until the module's end; consoles are processes."""


def numbers_of(text: str) -> list[float]:
    return [float(number) for number in re.findall(r'-?\d+(?:\.\d+)?', text)]


def off_by_a_pixel(*numbers: float) -> Any:
    """Compares with places and headings: a pixel is some millimetres of the floor."""
    return pytest.approx(list(numbers), abs=0.02, rel=0.03)


def drag_on_floor(page: Any, start: tuple[float, float], end: tuple[float, float]) -> None:
    """Press on a place of the floor, and let go at another one."""
    first, last = (
        page.evaluate('([x, y]) => goalwireScene.screen_of(x, y, 0)', list(at)) for at in (start, end)
    )
    page.mouse.move(*first)
    page.mouse.down()
    page.mouse.move(*last)
    page.mouse.up()


def test_a_hand_on_the_pad_drives_the_robot_until_it_lets_go(stage: Stage, open_page: OpenPage) -> None:
    robot = stage.robot()
    _, url = stage.console()
    page = open_page(f'{url}?view=robot')
    page.click('[data-teleop-on]')
    page.wait_for_selector('.q-dialog:has-text("stops when you let it go")')
    confirm(page)
    pad = page.locator('[data-teleop-pad]')
    pad.scroll_into_view_if_needed()
    box = pad.bounding_box()
    middle = box['x'] + box['width'] / 2, box['y'] + box['height'] / 2

    # Up is ahead at full speed, and as long as it is held.
    page.mouse.move(*middle)
    page.mouse.down()
    robot.expect('driven 0.00 0.00')
    page.mouse.move(middle[0], box['y'])
    robot.expect('driven 0.30 0.00')
    picture(page, 'teleop')
    page.mouse.move(box['x'], middle[1])
    robot.expect('driven 0.00 0.60')
    page.mouse.up()
    robot.expect('driven 0.00 0.00')
    assert page.locator('.q-notification').count() == 0, 'it was let go, and did not fall silent'

    # A window that loses the focus lets go, and so do STOP and a page that is closed.
    page.mouse.move(*middle)
    page.mouse.down()
    page.mouse.move(middle[0], box['y'])
    robot.expect('driven 0.30 0.00')
    page.evaluate("() => window.dispatchEvent(new Event('blur'))")
    robot.expect('driven 0.00 0.00')
    page.mouse.up()
    for let_go in (lambda: page.keyboard.press('Control+Shift+Space'), page.close):
        page.mouse.move(*middle)
        page.mouse.down()
        page.mouse.move(middle[0], box['y'])
        robot.expect('driven 0.30 0.00')
        let_go()
        robot.expect('driven 0.00 0.00')
        if not page.is_closed():
            page.mouse.up()


def test_a_console_that_ends_stops_what_it_drives(stage: Stage, open_page: OpenPage) -> None:
    robot = stage.robot()
    console, url = stage.console()
    page = open_page(f'{url}?view=robot')
    page.click('[data-teleop-on]')
    confirm(page)
    box = page.locator('[data-teleop-pad]').bounding_box()
    page.mouse.move(box['x'] + box['width'] / 2, box['y'] + box['height'] / 2)
    page.mouse.down()
    page.mouse.move(box['x'] + box['width'] / 2, box['y'])
    robot.expect('driven 0.30 0.00')
    console.send_signal(signal.SIGINT)
    robot.expect('driven 0.00 0.00')


def test_drags_on_the_floor_give_a_heading_a_pose_and_a_distance(stage: Stage, open_page: OpenPage) -> None:
    robot = stage.robot()
    _, url = stage.console()
    page = open_page(f'{url}?view=robot')
    # The robot's first pose moves the camera.
    until(page, '() => window.goalwireScene?.poses?.().left_arm !== undefined && goalwireScene.placed')

    # Measuring moves nothing, and the view stands still while a tool is chosen.
    page.click('[data-tool=measure]')
    page.wait_for_selector('[data-hint]:has-text("Press and drag to measure")')
    camera = page.evaluate('() => goalwireScene.camera.position.toArray()')
    drag_on_floor(page, (0.5, 0.0), (0.5, 0.5))
    label = page.locator('.gw-scene-label:has-text(" m, ")')
    wait_for(lambda: label.count() == 1, 'the distance')
    assert numbers_of(label.inner_text()) == off_by_a_pixel(0.5, 90.0)
    picture(page, 'measured')
    assert page.evaluate('() => goalwireScene.camera.position.toArray()') == pytest.approx(camera)

    # The robot's localiser is told a place and a heading.
    page.click('[data-tool=pose]')
    wait_for(lambda: label.count() == 0, 'no distance any more')
    drag_on_floor(page, (0.5, 0.0), (0.5, 0.5))
    page.wait_for_selector('.q-dialog:has-text("in odom")')
    asked = numbers_of(page.inner_text('.q-dialog [data-confirm]'))
    assert asked == off_by_a_pixel(0.5, 0.0, 90.0)
    confirm(page)
    told = robot.expect(r'told (.*)')[1]
    *place, degrees = numbers_of(told)
    assert place == pytest.approx(asked[:2], abs=0.06)
    assert degrees == pytest.approx(asked[2], abs=0.51)

    # Afterwards a drag turns the view again.
    page.wait_for_selector('[data-hint]:has-text("Click on the floor to send it there")')
    drag_on_floor(page, (0.5, 0.0), (0.5, 0.5))
    until(page, '([x]) => Math.abs(goalwireScene.camera.position.x - x) > 0.01', camera)
