"""The console under load: python benchmarks/console_load.py [--seconds N] [--browsers N] [--minutes N].

200 topics at 20 Hz and 50 goals. Views one by one, many browsers at once, browsers that have stopped reading
(one that is stopped by SIGSTOP, one that answers pings and reads nothing), and the memory over `--minutes`.
Prints a table with a verdict on each line; the exit code is 1 if a limit is not kept. Needs Chromium and
playwright. The server's share is processor time, so it can be told on a busy machine, too; frames cannot.
"""

from __future__ import annotations

import argparse
import base64
import json
import os
import re
import shutil
import signal
import socket
import subprocess
import sys
import tempfile
import threading
import time
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager
from pathlib import Path
from statistics import median
from urllib.request import urlopen

from playwright.sync_api import Browser, Page, Playwright, sync_playwright

MOST_FRAME_MS = 100.0
MOST_SHARE = 0.5
MOST_GROWTH_MB = 10.0
"""Between the second and the last quarter of the minutes."""
MOST_GAP_S = 5.0
"""Between two refreshes of the rates, which come each second."""

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
_CHROMIUM = shutil.which('chromium-headless-shell') or shutil.which('chromium')
FLAGS = ['--no-sandbox', '--use-gl=angle', '--use-angle=swiftshader', '--enable-unsafe-swiftshader']
FRAMES = """async (seconds) => {
  const took = [], changes = []; let last = performance.now(); const end = last + seconds * 1000;
  const observer = new MutationObserver(() => changes.push(performance.now()));
  observer.observe(document.querySelector('.gw-main'), {subtree: true, childList: true, characterData: true});
  await new Promise(done => { const tick = (now) => {
    took.push(now - last); last = now; now < end ? requestAnimationFrame(tick) : done(); };
    requestAnimationFrame(tick); });
  observer.disconnect();
  took.shift(); took.sort((a, b) => a - b);
  const at = (share) => took[Math.min(took.length - 1, Math.floor(took.length * share))];
  let gap = 0; for (let i = 1; i < changes.length; i++) gap = Math.max(gap, changes[i] - changes[i - 1]);
  const cells = [...document.querySelectorAll('tr[data-key^="/topic_"] td:last-child')];
  const rate = cells.reduce((sum, cell) => sum + (parseFloat(cell.textContent) || 0), 0);
  return [took.length, at(0.5), at(0.99), took[took.length - 1], gap / 1000, rate]; }"""


class Verdicts:
    """The table's lines."""

    def __init__(self) -> None:
        self.missed = 0

    def line(self, what: str, goal: str, measured: str, *, kept: bool) -> None:
        """Print one line."""
        self.missed += not kept
        print(f'| {what:34} | {goal:24} | {measured:66} | {"kept" if kept else "MISSED":6} |', flush=True)


class Server:
    """The console's process, as /proc shows it."""

    def __init__(self, pid: int) -> None:
        self._pid = pid

    def seconds(self) -> float:
        """Return the processor time that it has used."""
        fields = Path(f'/proc/{self._pid}/stat').read_text(encoding='utf-8').rpartition(')')[2].split()
        return (int(fields[11]) + int(fields[12])) / os.sysconf('SC_CLK_TCK')

    def megabytes(self) -> float:
        """Return the memory that it holds."""
        pages = int(Path(f'/proc/{self._pid}/statm').read_text(encoding='utf-8').split()[1])
        return pages * os.sysconf('SC_PAGE_SIZE') / 1e6


@contextmanager
def silent(url: str) -> Iterator[None]:
    """Open a page as a browser does, answer each ping blindly, and never read what comes."""
    with urlopen(f'{url}?view=topics') as answer:
        page = answer.read().decode()
    client = re.search(r"[\"']?client_id[\"']?: ?[\"']([0-9a-f-]{36})", page)
    assert client is not None
    port = int(url.rstrip('/').rpartition(':')[2])
    with socket.socket() as link:
        link.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, 4096)
        link.connect(('127.0.0.1', port))
        query = f'EIO=4&transport=websocket&client_id={client[1]}&tab_id=x&document_id=x&next_message_id=0'
        key = base64.b64encode(os.urandom(16)).decode()
        link.sendall(
            f'GET /_nicegui_ws/socket.io/?{query}&implicit_handshake=true HTTP/1.1\r\n'
            f'Host: localhost:{port}\r\nConnection: Upgrade\r\nUpgrade: websocket\r\n'
            f'Sec-WebSocket-Version: 13\r\nSec-WebSocket-Key: {key}\r\n\r\n'.encode()
        )
        assert link.recv(64).startswith(b'HTTP/1.1 101')
        link.sendall(_text(b'40'))
        ended = threading.Event()

        def answer_pings() -> None:
            while not ended.wait(2.0):
                try:
                    link.sendall(_text(b'3'))
                except OSError:
                    return  # the server has dropped it

        thread = threading.Thread(target=answer_pings)
        thread.start()
        try:
            yield
        finally:
            ended.set()
            thread.join()


def _text(payload: bytes) -> bytes:
    """Make a masked frame of text."""
    return bytes([129, 128 | len(payload)]) + bytes(4) + payload


@contextmanager
def stopped_browser(driver: Playwright, url: str) -> Iterator[None]:
    """Open the page in a Chromium of its own, and stop all its processes."""
    with tempfile.TemporaryDirectory(ignore_cleanup_errors=True) as folder:
        command = [str(_CHROMIUM), '--headless=new', *FLAGS, f'--user-data-dir={folder}']
        process = subprocess.Popen(
            [*command, '--remote-debugging-port=0', 'about:blank'],
            stderr=subprocess.PIPE,
            text=True,
            start_new_session=True,
        )
        try:
            assert process.stderr is not None
            address = next(line.split()[-1] for line in process.stderr if 'DevTools listening' in line)
            browser = driver.chromium.connect_over_cdp(address)
            page = browser.contexts[0].new_page()
            page.goto(f'{url}?view=topics', timeout=120_000)
            page.wait_for_selector('td:has-text("Hz")', timeout=120_000)
            os.killpg(process.pid, signal.SIGSTOP)
            yield
        finally:
            os.killpg(process.pid, signal.SIGKILL)
            process.wait()


class Bench:
    """The load, the console, and the browsers."""

    def __init__(self, url: str, server: Server, browser: Browser, seconds: float) -> None:
        self.url = url
        self.server = server
        self._browser = browser
        self._seconds = seconds
        self.verdicts = Verdicts()

    def open(self, view: str) -> Page:
        """Open a page."""
        page = self._browser.new_page(viewport={'width': 1280, 'height': 800})
        page.set_default_timeout(120_000)
        page.goto(f'{self.url}?view={view}')
        page.wait_for_selector('td:has-text("Hz")' if view == 'topics' else '.gw-main')
        return page

    def measure(self, page: Page, what: str, *, most_share: float = MOST_SHARE, frames: bool = True) -> None:
        """Measure for a while what a page shows and what the server uses, and print it."""
        before, began, memory = self.server.seconds(), time.monotonic(), self.server.megabytes()
        count, middle, p99, longest, gap, rates = page.evaluate(FRAMES, self._seconds)
        share = (self.server.seconds() - before) / (time.monotonic() - began)
        told = f'{share * 100:.0f} % at {rates:.0f} msg/s, {self.server.megabytes():.0f} MB'
        told += f' ({self.server.megabytes() - memory:+.0f})'
        self.verdicts.line(
            f'{what}: server', f'< {most_share * 100:.0f} % of a processor', told, kept=share < most_share
        )
        if frames:
            told = f'p50 {middle:.0f}, p99 {p99:.0f}, longest {longest:.0f} ms; '
            told += f'{count / self._seconds:.0f} frames/s'
            self.verdicts.line(
                f'{what}: frames', f'p99 < {MOST_FRAME_MS:.0f} ms', told, kept=p99 < MOST_FRAME_MS
            )
        if rates:
            told = f'longest {gap:.1f} s between refreshes'
            self.verdicts.line(f'{what}: refreshes', f'gap < {MOST_GAP_S:.0f} s', told, kept=gap < MOST_GAP_S)

    def watch_memory(self, minutes: float) -> None:
        """Note the memory again and again, and judge whether it is flat."""
        noted, end = [], time.monotonic() + minutes * 60
        began, used = time.monotonic(), self.server.seconds()
        while time.monotonic() < end:
            time.sleep(min(15.0, minutes * 4))
            noted.append(self.server.megabytes())
            if len(noted) % 8 == 0:
                print(f'  after {(time.monotonic() - began) / 60:.0f} min: {noted[-1]:.1f} MB', flush=True)
        share = (self.server.seconds() - used) / (time.monotonic() - began)
        quarter = max(1, len(noted) // 4)
        second, last = median(noted[quarter : 2 * quarter]), median(noted[-quarter:])
        told = f'{second:.1f} MB in the second quarter, {last:.1f} MB in the last; server {share * 100:.0f} %'
        self.verdicts.line(
            f'{minutes:g} minutes: memory',
            f'grows < {MOST_GROWTH_MB:.0f} MB',
            told,
            kept=last - second < MOST_GROWTH_MB,
        )


def measure_views(bench: Bench, driver: Playwright, browsers: int) -> None:
    """Measure views one by one, browsers that do not read, and many browsers."""
    page = bench.open('actions')
    bench.measure(page, 'actions, 50 goals')
    page.close()
    page = bench.open('topics')
    bench.measure(page, 'topics, 200 at 20 Hz')
    with silent(bench.url):
        bench.measure(page, 'beside one that never reads', frames=False)
    with stopped_browser(driver, bench.url):
        bench.measure(page, 'beside a stopped browser', frames=False)
    others = [bench.open('topics') for _ in range(browsers - 1)]
    page.bring_to_front()
    bench.measure(page, f'{len(others) + 1} browsers', most_share=1.0, frames=False)
    for each in (page, *others):
        each.close()


def main() -> int:
    """Start all, measure, and return 1 where a goal was missed."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument('--seconds', type=float, default=20.0, help='of each measurement (20)')
    parser.add_argument('--browsers', type=int, default=10, help='at once (10); 0: only the memory')
    parser.add_argument('--minutes', type=float, default=0.0, help='over which the memory is watched (0)')
    parser.add_argument('--domain', type=int, default=98, help='ROS_DOMAIN_ID (98)')
    arguments = parser.parse_args()
    environment = os.environ | {'ROS_DOMAIN_ID': str(arguments.domain)}
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
        console = start('-m', 'goalwire', 'console', '--no-open', '--json', '--port', '0')
        assert console.stdout is not None
        url = json.loads(console.stdout.readline())['url']
        driver = ends.enter_context(sync_playwright())
        browser = driver.chromium.launch(executable_path=_CHROMIUM, args=FLAGS)
        ends.callback(browser.close)
        bench = Bench(url, Server(console.pid), browser, arguments.seconds)
        if arguments.browsers:
            measure_views(bench, driver, arguments.browsers)
        if arguments.minutes:
            pages = [bench.open('topics'), bench.open('actions')]
            bench.watch_memory(arguments.minutes)
            for page in pages:
                page.close()
    return 1 if bench.verdicts.missed else 0


if __name__ == '__main__':
    sys.exit(main())
