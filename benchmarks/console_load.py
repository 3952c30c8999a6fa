"""The console under load: python benchmarks/console_load.py [--seconds N] [--browsers N].

200 topics at 20 Hz and 50 goals; one measured browser, others beside it, and one that has stopped
reading. Prints the server's share of a processor and its memory, and the browser's frames.
Needs Chromium and playwright.
"""

from __future__ import annotations

import argparse
import base64
import json
import os
import re
import shutil
import socket
import subprocess
import sys
import time
from contextlib import ExitStack, closing
from pathlib import Path
from urllib.request import urlopen

from playwright.sync_api import Page, sync_playwright

LOAD = """
import asyncio, goalwire
from example_interfaces.action import Fibonacci
from std_msgs.msg import Float64

async def count(goal):
    while True:
        goal.feedback(sequence=[1])
        await asyncio.sleep(1.0)

async def keep(client):
    await client.call(order=1)

async def main():
    async with goalwire.Node('load') as node:
        node.action_server(Fibonacci, 'count', count)
        client = node.action(Fibonacci, 'count')
        goals = [asyncio.create_task(keep(client)) for _ in range(50)]
        topics = [node.publisher(Float64, f'topic_{number}') for number in range(200)]
        print('ready', flush=True)
        async for _ in node.timer(0.05):
            for publisher in topics:
                publisher.publish(data=1.0)

asyncio.run(main())
"""
FLAGS = ['--no-sandbox', '--use-gl=angle', '--use-angle=swiftshader', '--enable-unsafe-swiftshader']
FRAMES = """async (seconds) => {
  const took = []; let last = performance.now(); const end = last + seconds * 1000;
  await new Promise(done => { const tick = (now) => {
    took.push(now - last); last = now; now < end ? requestAnimationFrame(tick) : done(); };
    requestAnimationFrame(tick); });
  took.shift(); took.sort((a, b) => a - b);
  const at = (share) => took[Math.floor(took.length * share)];
  return [took.length, at(0.5), at(0.95), took[took.length - 1]]; }"""


def used(pid: int) -> tuple[float, float]:
    """Processor seconds and MB of a process."""
    fields = Path(f'/proc/{pid}/stat').read_text(encoding='utf-8').rpartition(')')[2].split()
    seconds = (int(fields[11]) + int(fields[12])) / os.sysconf('SC_CLK_TCK')
    return seconds, int(fields[21]) * os.sysconf('SC_PAGE_SIZE') / 1e6


def deaf(url: str) -> socket.socket:
    """Open a page as a browser does, and never read what comes."""
    with urlopen(f'{url}?view=topics') as answer:
        page = answer.read().decode()
    client = re.search(r"[\"']?client_id[\"']?: ?[\"']([0-9a-f-]{36})", page)
    assert client is not None
    port = int(url.rstrip('/').rpartition(':')[2])
    link = socket.create_connection(('127.0.0.1', port))
    link.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, 4096)
    query = f'EIO=4&transport=websocket&client_id={client[1]}&tab_id=deaf&document_id=deaf&next_message_id=0'
    key = base64.b64encode(os.urandom(16)).decode()
    link.sendall(
        f'GET /_nicegui_ws/socket.io/?{query}&implicit_handshake=true HTTP/1.1\r\nHost: localhost:{port}\r\n'
        f'Connection: Upgrade\r\nUpgrade: websocket\r\nSec-WebSocket-Version: 13\r\n'
        f'Sec-WebSocket-Key: {key}\r\n\r\n'.encode()
    )
    link.recv(4096)
    link.sendall(b'\x81\x82\0\0\0\x0040')
    return link


def measure(page: Page, pid: int, seconds: float, what: str) -> None:
    """Print one line of figures."""
    before, _ = used(pid)
    began = time.monotonic()
    frames, median, p95, longest = page.evaluate(FRAMES, seconds)
    after, memory = used(pid)
    share = (after - before) / (time.monotonic() - began)
    print(
        f'{what}: server {share * 100:.0f} % of a processor, {memory:.0f} MB; '
        f'{frames / seconds:.0f} frames/s, p50 {median:.0f}, p95 {p95:.0f}, longest {longest:.0f} ms',
        flush=True,
    )


def main() -> int:
    """Measure views, then many browsers, then beside a browser that does not read."""
    parser = argparse.ArgumentParser()
    parser.add_argument('--seconds', type=float, default=20.0)
    parser.add_argument('--browsers', type=int, default=10)
    arguments = parser.parse_args()
    environment = os.environ | {'ROS_DOMAIN_ID': '98'}
    with ExitStack() as ends:

        def start(*command: str) -> subprocess.Popen[str]:
            process = subprocess.Popen(
                [sys.executable, *command], env=environment, stdout=subprocess.PIPE, text=True
            )
            ends.callback(process.wait)
            ends.callback(process.terminate)
            return process

        load = start('-c', LOAD)
        assert load.stdout is not None
        load.stdout.readline()
        console = start('-m', 'goalwire.cli', 'console', '--no-open', '--json', '--port', '0')
        assert console.stdout is not None
        url = json.loads(console.stdout.readline())['url']
        driver = ends.enter_context(sync_playwright())
        browser = driver.chromium.launch(executable_path=shutil.which('chromium'), args=FLAGS)
        ends.callback(browser.close)

        def opened(view: str) -> Page:
            page = browser.new_page(viewport={'width': 1280, 'height': 800})
            page.set_default_timeout(120_000)
            page.goto(f'{url}?view={view}')
            if view == 'topics':
                page.wait_for_selector('td:has-text("Hz")')
            return page

        page = opened('actions')
        measure(page, console.pid, arguments.seconds, 'actions, 50 goals')
        page.close()
        page = opened('topics')
        measure(page, console.pid, arguments.seconds, 'topics, 200 at 20 Hz')
        with closing(deaf(url)):
            measure(page, console.pid, arguments.seconds, 'and one that does not read')
        others = [opened('topics') for _ in range(arguments.browsers - 1)]
        page.bring_to_front()
        measure(page, console.pid, arguments.seconds, f'{len(others) + 1} browsers on topics')
    return 0


if __name__ == '__main__':
    sys.exit(main())
