"""Draws docs/how-to/house.png: the humanoid on its way through the house, as the console shows it.

python tools/house_picture.py [--physics]

Needs Chromium and playwright. With --physics it needs a machine that keeps real time.
"""

from __future__ import annotations

import json
import os
import subprocess
import sys
from contextlib import ExitStack

from tools.console_picture import CHROMIUM, FLAGS, MOST_BYTES, PATIENCE_MS, ROOT

PICTURE = ROOT / 'docs' / 'how-to' / 'house.png'
GOAL = ('1.55', '5.0')  # through the door of the living room, into the corridor
PASSED = (0.55, 1.6)  # m from the start along x and y, where the picture is taken
CAMERA, TARGET = (-1.6, -1.3, 2.3), (1.4, 2.6, 0.6)

IS_DRAWN = """() => {
  let count = 0;
  window.goalwireScene?.robot.traverse((each) => (count += each.isMesh ? 1 : 0));
  return count > 50 && goalwireScene.layers.spots('/map').length > 0;
}"""
LOOK = """([camera, target]) => {
  goalwireScene.set_follow(false);
  goalwireScene.camera.position.set(...camera);
  goalwireScene.controls.target.set(...target);
  goalwireScene.wake();
}"""
HAS_PASSED = """([x, y]) => {
  const base = window.goalwireScene?.poses().base_link;
  return base && base[0] > x && base[1] > y;
}"""


def main() -> int:
    """Start the robot in its house and a console, send it, take the picture, end all."""
    from playwright.sync_api import sync_playwright

    physics = '--physics' if '--physics' in sys.argv[1:] else '--no-physics'
    environment = os.environ | {'ROS_DOMAIN_ID': '96', 'PYTHONPATH': str(ROOT / 'robot' / 'humanoid')}
    with ExitStack() as ends:

        def start(*command: str) -> subprocess.Popen[str]:
            process = subprocess.Popen(
                [sys.executable, '-m', *command], env=environment, cwd=ROOT, stdout=subprocess.PIPE, text=True
            )
            ends.callback(process.wait)
            ends.callback(process.terminate)
            return process

        robot = start('humanoid', 'up', '--world', 'house', physics)
        console = start('goalwire', 'console', '--no-open', '--json', '--port', '0')
        assert robot.stdout is not None
        assert console.stdout is not None
        url = json.loads(console.stdout.readline())['url']
        while 'Navigator ready' not in robot.stdout.readline():
            assert robot.poll() is None, 'the robot has ended'
        driver = ends.enter_context(sync_playwright())
        browser = driver.chromium.launch(executable_path=CHROMIUM, args=FLAGS)
        ends.callback(browser.close)
        page = browser.new_page(viewport={'width': 1280, 'height': 800})
        page.set_default_timeout(PATIENCE_MS)
        page.goto(f'{url}?view=robot')
        page.wait_for_function(IS_DRAWN)
        page.evaluate(LOOK, [CAMERA, TARGET])
        start('humanoid', 'move', *GOAL)
        page.wait_for_function(HAS_PASSED, arg=list(PASSED))
        page.screenshot(path=str(PICTURE))
    size = PICTURE.stat().st_size
    print(f'{PICTURE.relative_to(ROOT)}: {size} bytes')
    return 0 if size < MOST_BYTES else 1


if __name__ == '__main__':
    sys.exit(main())
