"""The console's 3D scene with everything on: python benchmarks/scene_load.py [--seconds N].

The kinematic humanoid goes about in its house. Beside its own layers there are a cloud of 50,000 points and
200 markers, ten times a second each. Chromium draws every layer, all axes and their names, and renders in
software. Prints a table; the exit code is 1 if a limit is missed. The browser shares the machine with the
robot, so the figures of its frames need a machine that is free.
"""

from __future__ import annotations

import argparse
import json
import os
import subprocess
import sys
import threading
import time
from contextlib import ExitStack
from pathlib import Path

from playwright.sync_api import Page

ROOT = Path(__file__).resolve().parents[1]
sys.path.insert(0, str(ROOT))

from benchmarks.console_load import FRAMES, Server, Verdicts  # noqa: E402
from tools.console_picture import open_page  # noqa: E402

MOST_FRAME_MS = 50.0
MOST_SHARE = 0.5
WAY = ('7.0', '3.0')  # m on the map: into the kitchen
CLOUD, MARKERS = '/dense_points', '/many_markers'
SETTLED = 10.0  # s in which the page finds out how much detail the machine can draw
LOAD = """
import asyncio, goalwire
import numpy as np
from sensor_msgs.msg import PointCloud2, PointField
from visualization_msgs.msg import Marker, MarkerArray

COUNT = 50_000

def cloud(chance):
    spots = np.empty((COUNT, 4), np.float32)
    spots[:, :3] = chance.uniform((-2, -2, 0), (10, 10, 2), (COUNT, 3))
    spots[:, 3] = chance.integers(0, 1 << 24, COUNT, np.uint32).view(np.float32)
    names = enumerate(('x', 'y', 'z', 'rgb'))
    fields = [PointField(name=name, offset=4 * at, datatype=7, count=1) for at, name in names]
    message = PointCloud2(height=1, width=COUNT, fields=fields, point_step=16, row_step=16 * COUNT)
    message.header.frame_id = 'map'
    message.data = spots.tobytes()
    return message

def marker(number, tick):
    message = Marker(ns='many', id=number, type=Marker.SPHERE)
    message.header.frame_id = 'map'
    message.pose.position.x, message.pose.position.y = number % 20 * 0.5, number // 20 * 0.5
    message.pose.position.z = 2.0 + 0.1 * (tick % 10)
    message.scale.x = message.scale.y = message.scale.z = 0.1
    message.color.b = message.color.a = 1.0
    return message

async def main():
    async with goalwire.Node('load') as node:
        points = node.publisher(PointCloud2, 'dense_points')
        markers = node.publisher(MarkerArray, 'many_markers')
        clouds = [cloud(np.random.default_rng(seed)) for seed in range(4)]
        arrays = [[marker(number, tick) for number in range(200)] for tick in range(10)]
        tick = 0
        async for _ in node.timer(0.1):
            points.publish(clouds[tick % 4])
            markers.publish(markers=arrays[tick % 10])
            tick += 1

asyncio.run(main())
"""


def turn_all_on(page: Page) -> int:
    """Turn on every layer, the axes and their names; return the number of layers."""
    page.wait_for_selector(f'[data-layer="{CLOUD}"]')
    page.wait_for_selector(f'[data-layer="{MARKERS}"]')
    topics = page.eval_on_selector_all('[data-layer]', 'all => all.map(each => each.dataset.layer)')
    for topic in topics:
        switch = page.locator(f'[data-layer="{topic}"]')
        if switch.get_attribute('aria-checked') != 'true':
            switch.click()
    page.click('[data-axes]')
    page.click('[data-axis-names]')
    page.wait_for_function('topic => goalwireScene.layers.spots(topic).length > 0', arg=CLOUD)
    page.wait_for_function('topic => goalwireScene.layers.spots(topic).length > 0', arg=MARKERS)
    return len(topics)


def main() -> int:
    """Start all, measure, end all."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument('--seconds', type=float, default=20.0, help='of the measurement (20)')
    options = parser.parse_args()
    environment = os.environ | {'ROS_DOMAIN_ID': '98', 'PYTHONPATH': str(ROOT / 'robot' / 'humanoid')}
    with ExitStack() as ends:

        def start(*command: str, output: int = subprocess.DEVNULL) -> subprocess.Popen[str]:
            process = subprocess.Popen(
                [sys.executable, *command], env=environment, cwd=ROOT, stdout=output, text=True
            )
            ends.callback(process.wait)
            ends.callback(process.terminate)
            return process

        robot = start('-m', 'humanoid', 'up', '--world', 'house', '--no-physics', output=subprocess.PIPE)
        console = start(
            '-m', 'goalwire', 'console', '--no-open', '--json', '--port', '0', output=subprocess.PIPE
        )
        start('-c', LOAD)
        assert robot.stdout is not None
        assert console.stdout is not None
        url = json.loads(console.stdout.readline())['url']
        while 'Navigator ready' not in robot.stdout.readline():
            assert robot.poll() is None, 'the robot has ended'
        threading.Thread(target=robot.stdout.read, daemon=True).start()  # a full pipe would hold it up
        page = open_page(ends)
        page.goto(f'{url}?view=robot')
        layers = turn_all_on(page)
        start('-m', 'humanoid', 'move', *WAY)
        page.wait_for_timeout(SETTLED * 1000)
        return measure(page, Server(console.pid), layers, options.seconds)


def measure(page: Page, server: Server, layers: int, seconds: float) -> int:
    """Measure for a while, print the lines, and return the exit code."""
    verdicts = Verdicts()
    before, began = server.seconds(), time.monotonic()
    count, middle, p99, longest, *_ = page.evaluate(FRAMES, seconds)
    share = (server.seconds() - before) / (time.monotonic() - began)
    what = f'{layers} layers, axes, names'
    told = f'{share * 100:.0f} %, {server.megabytes():.0f} MB'
    verdicts.line(
        f'{what}: server', f'< {MOST_SHARE * 100:.0f} % of a processor', told, kept=share < MOST_SHARE
    )
    level = page.evaluate('() => goalwireScene.detail.level')
    told = f'p50 {middle:.0f}, p99 {p99:.0f}, longest {longest:.0f} ms; {count / seconds:.0f} frames/s; '
    told += f'{level} steps of detail left out'
    verdicts.line(f'{what}: frames', f'p99 < {MOST_FRAME_MS:.0f} ms', told, kept=p99 < MOST_FRAME_MS)
    return 1 if verdicts.missed else 0


if __name__ == '__main__':
    sys.exit(main())
