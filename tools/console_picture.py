"""Draws docs/how-to/console.png: the humanoid where it was sent, as the console shows it.

python tools/console_picture.py

Needs Chromium and playwright. tests/apps/console/test_humanoid.py takes the same picture and looks at it.
"""

from __future__ import annotations

import json
import os
import shutil
import subprocess
import sys
from contextlib import ExitStack
from pathlib import Path
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from playwright.sync_api import Page

ROOT = Path(__file__).parents[1]
PICTURE = ROOT / 'docs' / 'how-to' / 'console.png'
MOST_BYTES = 1_000_000
_CHROMIUMS = 'chromium-headless-shell', 'chromium', 'chromium-browser', 'google-chrome'
CHROMIUM = next(filter(None, map(shutil.which, _CHROMIUMS)), None)
"""The first is the same browser without windows of its own, which take a third of the processor's time."""
FLAGS = ['--no-sandbox', '--disable-gpu', '--enable-unsafe-swiftshader']
"""The processor draws the robot's scene alone, and not the whole page, too."""
PATIENCE_MS = 120_000
GOAL = (1.1, 0.7)
WIDTH, HEIGHT = 1280, 800
DRAW_ALL = """() => {
  const scene = goalwireScene;
  scene.detail.note = () => false;
  scene.draw_with({ shadows: true, coarsely: false, scale: 2 }); // smooth edges
  scene.renderer.render(scene.scene, scene.camera);
}"""
IS_LOST = "() => document.body.classList.contains('gw-is-lost')"


def main() -> int:
    """Start the robot and a console, take the picture, end both."""
    environment = os.environ | {
        'ROS_DOMAIN_ID': '97',
        'PYTHONPATH': str(ROOT / 'robot' / 'humanoid'),
        'HUMANOID_PHYSICS': '0',  # a body in physics sways, and does not stop within the centimetre below
    }
    with ExitStack() as ends:
        for command in (['-m', 'humanoid', 'up'], ['-m', 'goalwire', 'console', *_CONSOLE]):
            process = subprocess.Popen(
                [sys.executable, *command], env=environment, cwd=ROOT, stdout=subprocess.PIPE, text=True
            )
            ends.callback(process.wait)
            ends.callback(process.terminate)
        assert process.stdout is not None
        url = json.loads(process.stdout.readline())['url']
        take(open_page(ends), url, PICTURE)
    size = PICTURE.stat().st_size
    print(f'{PICTURE.relative_to(ROOT)}: {size} bytes')
    return 0 if size < MOST_BYTES else 1


_CONSOLE = ['--no-open', '--json', '--port', '0']


def open_page(ends: ExitStack) -> Page:
    """Open a page of Chromium; `ends` closes it."""
    from playwright.sync_api import sync_playwright

    driver = ends.enter_context(sync_playwright())
    browser = driver.chromium.launch(executable_path=CHROMIUM, args=FLAGS)
    ends.callback(browser.close)
    page = browser.new_page(viewport={'width': WIDTH, 'height': HEIGHT})
    page.set_default_timeout(PATIENCE_MS)
    return page


def take(page: Page, url: str, file: Path) -> None:
    """Send the robot to a place on the floor, and take the picture of the page when it is there."""
    page.set_default_timeout(PATIENCE_MS)
    page.goto(f'{url}?view=robot')
    page.wait_for_selector('[data-way]:visible')
    # The camera follows the robot up when its pose comes: before that, a point of the floor is elsewhere.
    page.wait_for_function(
        '() => window.goalwireScene?.poses?.().base_link?.[2] > 0.5'
        ' && Math.abs(goalwireScene.controls.target.z - 0.6) < 0.001'
    )
    page.wait_for_function(f'() => !({IS_LOST})()')  # it takes no click before
    x, y = page.evaluate('([x, y]) => goalwireScene.screen_of(x, y, 0)', list(GOAL))
    page.mouse.click(x, y)
    page.click('.q-dialog [data-send]')
    page.wait_for_function(
        '([x, y]) => { const base = goalwireScene.poses().base_link, eye = goalwireScene.controls.target;'
        ' return base && Math.hypot(base[0] - x, base[1] - y) < 0.01'
        ' && Math.hypot(eye.x - x, eye.y - y) < 0.01 }',
        arg=list(GOAL),
    )
    page.mouse.move(500, 760)
    # On a busy computer the page may lose its console for a while, also while it draws, and is grey then.
    while True:
        page.wait_for_function(f'() => !({IS_LOST})()')
        # On a slow computer the page draws ever less detail while the robot walks. The picture has all of it.
        page.evaluate(DRAW_ALL)
        page.screenshot(path=str(file))
        if not page.evaluate(IS_LOST):
            return


if __name__ == '__main__':
    sys.exit(main())
