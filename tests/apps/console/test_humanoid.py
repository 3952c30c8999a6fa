"""`humanoid up --view` in a real browser: the README's picture, made anew and looked at."""

from __future__ import annotations

import base64
import os
import signal
from pathlib import Path
from typing import Any

import pytest
from helpers.console import Stage, screenshots
from helpers.page import new_context, until
from helpers.patience import BROWSER
from helpers.robot import humanoid, robot_env

from tools import console_picture

pytestmark = [pytest.mark.slow, pytest.mark.timeout(400)]

# How many pixels of a box are accents of the robot's (blue), and how many its joints and feet (dark).
COUNT = """async ([picture, left, top, right, bottom]) => {
  const image = new Image();
  image.src = 'data:image/png;base64,' + picture;
  await image.decode();
  const canvas = new OffscreenCanvas(image.width, image.height).getContext('2d');
  canvas.drawImage(image, 0, 0);
  const {data} = canvas.getImageData(left, top, right - left, bottom - top);
  let [blue, dark] = [0, 0];
  for (let at = 0; at < data.length; at += 4) {
    const [r, g, b] = [data[at], data[at + 1], data[at + 2]];
    blue += b > 90 && b > 1.35 * g && b > 2.5 * r && g > 1.2 * r;
    dark += r < 80 && g < 80 && b < 85;
  }
  return [blue, dark];
}"""


@pytest.fixture(autouse=True)
def nothing_left_behind() -> None:
    """The browser's driver keeps threads of its own until the module's end."""


def where(page: Any) -> list[int]:
    """The box on the screen in which the robot's links are: left, top, right, bottom."""
    spots = page.evaluate(
        'Object.values(goalwireScene.poses()).map(([x, y, z]) => goalwireScene.screen_of(x, y, z))'
    )
    across, down = zip(*spots, strict=True)
    return [int(min(across)), int(min(down)), int(max(across)), int(max(down))]


@pytest.mark.long
def test_the_readmes_picture_shows_the_robot(stage: Stage, chromium: Any, tmp_path: Path) -> None:
    stage.env = robot_env('rmw_zenoh_cpp') | {'BROWSER': 'true'}
    file = (screenshots() or tmp_path) / 'humanoid.png'
    with humanoid('up', '--view', env=stage.env) as up:
        pid = int(up.expect(r'\[view\] pid (\d+)', BROWSER)[1])
        url = up.expect(r'\[view\] the console is at (http://localhost:\d+/)', BROWSER)[1]
        page = new_context(chromium, console_picture.WIDTH, console_picture.HEIGHT).new_page()
        console_picture.take(page, url, file)
        eye = chromium.new_page()

        def seen(picture: bytes, left: int, top: int, right: int, bottom: int) -> tuple[int, int]:
            text = base64.b64encode(picture).decode()
            blue, dark = eye.evaluate(COUNT, [text, left, top, right, bottom])
            return blue, dark

        # In the picture the robot stands in its box, in its colours, and nowhere else.
        left, top, right, bottom = where(page)
        blue, dark = seen(file.read_bytes(), left, top, right, bottom)
        assert blue > 100, 'accents of its arms and chest'
        assert dark > 1000, 'its joints and feet'
        wide = right - left
        for beside in (left - 2 * wide, right + wide):
            blue, dark = seen(file.read_bytes(), beside, top, beside + wide, bottom)
            assert blue + dark == 0, (beside, blue, dark)
        # Without it, the box is empty: what was counted was the robot.
        drawn = page.evaluate(
            '() => { const scene = goalwireScene; scene.robot.visible = false; scene.wake();'
            ' return scene.rendered }'
        )
        until(page, '(drawn) => goalwireScene.rendered > drawn', drawn)
        blue, dark = seen(page.screenshot(), left, top, right, bottom)
        assert blue + dark == 0, (blue, dark)
        assert file.stat().st_size < console_picture.MOST_BYTES
        page.close()
        eye.close()

        # Without the page the robot goes on.
        os.kill(pid, signal.SIGKILL)
        up.expect(r'^view \(pid \d+\) was killed by SIGKILL; the others go on')
        up.send_signal(signal.SIGINT)
        assert up.wait() == 0
