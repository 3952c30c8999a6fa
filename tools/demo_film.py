"""Films `make demo PHYSICS=1 VIEW=1`: the mission in the house, as the console shows it.

python -m tools.demo_film [FOLDER] [--no-physics]

Writes a picture each two seconds into FOLDER (build/film), named by the second and the mission's step, and
docs/how-to/house.png, once the robot has turned away from the door that closed before it. Ends with the exit
code of the demo. Needs Chromium and playwright, and a machine that keeps real time.
"""

from __future__ import annotations

import argparse
import os
import re
import subprocess
import sys
import threading
import time
from contextlib import ExitStack
from pathlib import Path
from typing import TYPE_CHECKING

from tools.console_picture import DRAW_ALL, MOST_BYTES, PATIENCE_MS, ROOT, open_page

if TYPE_CHECKING:
    from playwright.sync_api import Page

PICTURE = ROOT / 'docs' / 'how-to' / 'house.png'
BETWEEN = 2.0  # s between two pictures of the film
DRAW_AS_BEFORE = """() => {
  const scene = goalwireScene;
  delete scene.detail.note;
  scene.draw_with(scene.detail.wanted);
}"""
SOON = 0.2  # s, while the moment of the pages' picture is awaited
STEP = '-to-the-kitchen'
CAMERA, TARGET = (-1.0, -1.6, 3.0), (2.7, 2.0, 0.5)
EYE = (-1.9, -1.9, 2.6)  # of the film: m from the robot, which it follows

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

FOLLOW = """([x, y, z]) => {
  const eye = goalwireScene.controls.target.clone();
  eye.set(eye.x + x, eye.y + y, eye.z + z);
  goalwireScene.camera.position.copy(eye);
  goalwireScene.set_follow(true);
  goalwireScene.wake();
}"""
IS_BEFORE_THE_DOOR = '() => goalwireScene.poses().base_link[0] > 2.4'
HAS_TURNED = '() => goalwireScene.poses().base_link[1] > 1.1'


class Demo:
    """The demo's process, and what it has printed."""

    def __init__(self, *, physics: bool) -> None:
        command = ['-m', 'humanoid', 'demo', '--view', '--world', 'house']
        self._process = subprocess.Popen(
            [sys.executable, *command, '--physics' if physics else '--no-physics'],
            env=os.environ | {'ROS_DOMAIN_ID': '96', 'BROWSER': 'true', 'PYTHONUNBUFFERED': '1'},
            cwd=ROOT,
            stdout=subprocess.PIPE,
            text=True,
        )
        self.url = ''
        self.step = ''  # as 14-to-the-kitchen
        self._served = threading.Event()
        self._reader = threading.Thread(target=self._read)
        self._reader.start()

    def _read(self) -> None:
        assert self._process.stdout is not None
        for line in self._process.stdout:
            print(line, end='', flush=True)
            if found := re.search(r'the console is at (http[^ ;]+)', line):
                self.url = found[1]
                self._served.set()
            elif found := re.match(r'\[(\d+)/\d+\] ([^:;,(]+)', line):
                self.step = f'{int(found[1]):02}-{found[2].strip().replace(" ", "-")}'
        self._served.set()

    def await_page(self) -> None:
        self._served.wait(PATIENCE_MS / 1000)
        if not self.url:
            raise SystemExit('the page was not served')

    @property
    def runs(self) -> bool:
        return self._process.poll() is None

    def end(self) -> int:
        """Stop the demo if it still runs; return its exit code."""
        if self.runs:
            self._process.terminate()
        code = self._process.wait()
        self._reader.join()
        return code


def film(demo: Demo, page: Page, folder: Path) -> None:
    """Take a picture each two seconds until the demo ends, and one for the pages before the closed door."""
    began, was_before, drawn = time.monotonic(), False, False
    while demo.runs:
        taken = time.monotonic()
        in_kitchen_step = demo.step.endswith(STEP)
        was_before = was_before or (in_kitchen_step and page.evaluate(IS_BEFORE_THE_DOOR))
        if was_before and not drawn and page.evaluate(HAS_TURNED):
            drawn = True
            page.evaluate(LOOK, [CAMERA, TARGET])
            page.evaluate(DRAW_ALL)
            page.screenshot(path=str(PICTURE))
            page.evaluate(DRAW_AS_BEFORE)
            page.evaluate(FOLLOW, EYE)
        page.screenshot(path=str(folder / f'{taken - began:05.1f}-{demo.step}.png'))
        pause = SOON if was_before and not drawn else BETWEEN
        page.wait_for_timeout(max(pause - (time.monotonic() - taken), 0.0) * 1000)
    if not drawn:
        raise SystemExit('the demo ended before the robot turned away from a closed door')


def main() -> int:
    """Start the demo, film it, end all."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument('folder', type=Path, nargs='?', default=ROOT / 'build' / 'film')
    parser.add_argument('--physics', action=argparse.BooleanOptionalAction, default=True)
    options = parser.parse_args()
    options.folder.mkdir(parents=True, exist_ok=True)
    with ExitStack() as ends:
        demo = Demo(physics=options.physics)
        ends.callback(demo.end)
        demo.await_page()
        page = open_page(ends)
        page.goto(f'{demo.url}{"&" if "?" in demo.url else "?"}view=robot')
        page.wait_for_function(IS_DRAWN)
        page.evaluate(FOLLOW, EYE)
        film(demo, page, options.folder)
        code = demo.end()
    size = PICTURE.stat().st_size
    print(f'{PICTURE.relative_to(ROOT)}: {size} bytes')
    return code if size < MOST_BYTES else 1


if __name__ == '__main__':
    sys.exit(main())
