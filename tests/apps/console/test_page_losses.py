"""The page where something is lost beneath it or beside it."""

from __future__ import annotations

import re
import socket
import urllib.request
from collections.abc import Callable
from contextlib import suppress
from typing import Any

import pytest
from helpers.console import PROGRAMS, Stage, picture
from helpers.page import until
from helpers.patience import PATIENCE
from helpers.processes import Program

OpenPage = Callable[[str], Any]

pytestmark = [pytest.mark.slow, pytest.mark.timeout(400)]

CONNECT, PONG = (bytes([129, 128 | len(text), 0, 0, 0, 0]) + text for text in (b'40', b'3'))
"""Frames of a web socket: as socket.io is joined, and as its pings are answered."""
ROUTER = (
    "import sys; from goalwire.apps.cli.main import run_command; sys.exit(run_command('ros2', ['router']))"
)


@pytest.fixture(autouse=True)
def nothing_left_behind() -> None:
    """The browser's driver keeps threads of its own until the module's end; consoles are processes."""


def router(stage: Stage) -> Program:
    """Start the router at which the stage's programs meet."""
    started = stage.program(ROUTER)
    started.expect('^router [0-9a-f]+ listens')
    return started


@pytest.mark.long
def test_a_router_that_is_killed_is_missed_until_it_is_back(stage: Stage, open_page: OpenPage) -> None:
    """Clients reach each other through the router alone. In each run test_page.py loses a robot."""
    stage.env['GOALWIRE_ROUTER'] = 'off'
    first = router(stage)
    routers = stage.env
    stage.env = routers | {'ZENOH_CONFIG_OVERRIDE': 'mode="client"'}
    robot = stage.robot()
    _, url = stage.console()
    page = open_page(f'{url}?view=robot')
    page.wait_for_selector('[data-fresh]:text-is("live")')
    page.wait_for_selector('[data-battery]:text-is("battery 62 %")')
    page.wait_for_selector('[data-estop]')

    first.kill()
    page.wait_for_selector('[data-nodes]:has-text("nobody else on the wire")')
    page.wait_for_selector('[data-gone]:has-text("It has gone")')
    page.wait_for_selector('.gw-stale')
    page.wait_for_selector('[data-battery]', state='hidden')
    page.wait_for_selector('[data-estop]', state='hidden')
    picture(page, 'router-gone')

    stage.env = routers
    router(stage)
    page.wait_for_selector('[data-fresh]:text-is("live")')
    page.wait_for_selector('.gw-stale', state='detached')
    page.wait_for_selector('[data-battery]:text-is("battery 62 %")')
    pose = page.evaluate('() => goalwireScene.poses().left_arm')
    until(page, '(pose) => Math.abs(goalwireScene.poses().left_arm[4] - pose[4]) > 0.1', pose)
    page.click('[data-estop]')
    robot.expect('stopped')


@pytest.mark.long
def test_peers_lose_nothing_with_the_router_but_those_who_come(stage: Stage, open_page: OpenPage) -> None:
    """Peers are joined by links of their own."""
    stage.env |= {'GOALWIRE_ROUTER': 'off'}
    first = router(stage)
    stage.robot()
    _, url = stage.console()
    page = open_page(f'{url}?view=robot')
    page.wait_for_selector('[data-fresh]:text-is("live")')
    first.kill()
    first.wait()
    stage.program(PROGRAMS / 'introspected.py').expect('ready')
    pose = page.evaluate('() => goalwireScene.poses().left_arm')
    until(page, '(pose) => Math.abs(goalwireScene.poses().left_arm[4] - pose[4]) > 0.1', pose)
    page.wait_for_selector('[data-fresh]:text-is("live")')
    router(stage)
    page.click('[data-view=services]')
    page.wait_for_selector('tr[data-key="/add"]')


def test_a_browser_that_reads_nothing_holds_up_nobody(stage: Stage, open_page: OpenPage) -> None:
    stage.robot()
    waits = {'page.kept._ANSWER_S': 0.2, 'page.robot_view.RobotView.period': 1 / 15}
    console, url = stage.console(waits=waits)
    port = int(url.rstrip('/').rpartition(':')[2])
    with socket.socket() as silent:
        silent.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, 4096)
        silent.settimeout(PATIENCE)
        silent.connect(('127.0.0.1', port))
        silent.sendall(_socket_request(port))
        got = silent.recv(64)
        silent.sendall(CONNECT)
        page = open_page(f'{url}?view=robot')
        until(page, '() => window.goalwireScene?.poses?.().left_arm !== undefined')
        # Each count is one refresh of the view: sent, shown, and said to be shown.
        page.evaluate("""() => {
          const scene = window.goalwireScene, frame = scene.frame;
          window.refreshes = 0;
          scene.frame = (update) => { window.refreshes++; return frame.call(scene, update); }; }""")
        for count in range(10, 31, 10):  # some two seconds: the view of the silent one begins after 0.2 s
            with suppress(OSError):  # it may have been slow for so long that it was given up
                silent.sendall(PONG)
            until(page, '(count) => window.refreshes > count', count)
        page.close()
        console.kill()
        while chunk := silent.recv(65536):
            got += chunk
    # It was sent no second refresh, for it never said that it showed the first.
    assert got.count(b'\\"frame\\"') <= 1
    before, asked, _ = got.partition(b'requestAnimationFrame')
    assert asked, 'it was asked whether it shows it'
    assert before.count(b'request_id') == 1, 'one question brings the theme and the layout'


def _socket_request(port: int) -> bytes:
    """Open a page, and return the request for the web socket that its script would open."""
    with urllib.request.urlopen(f'http://localhost:{port}/?view=robot', timeout=PATIENCE) as answer:
        client = re.search(r'client_id[^0-9a-f]{1,12}([0-9a-f-]{36})', answer.read().decode())
    assert client is not None
    query = f'EIO=4&transport=websocket&client_id={client[1]}&tab_id=x&document_id=x&next_message_id=0'
    return (
        f'GET /_nicegui_ws/socket.io/?{query}&implicit_handshake=true HTTP/1.1\r\n'
        f'Host: localhost:{port}\r\nConnection: Upgrade\r\nUpgrade: websocket\r\n'
        'Sec-WebSocket-Version: 13\r\nSec-WebSocket-Key: AAAAAAAAAAAAAAAAAAAAAA==\r\n\r\n'
    ).encode()
