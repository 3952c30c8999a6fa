"""How a browser comes in with the token: by a link of another site, and again when it has the cookie."""

from __future__ import annotations

from collections.abc import Iterator
from functools import partial
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from threading import Thread
from typing import Any

import pytest
from helpers.console import Stage, picture
from helpers.page import new_context

pytestmark = [pytest.mark.slow, pytest.mark.timeout(400)]

TOKEN = 'the-token'
FIRST_WORDS = '[data-nodes]:has-text("nobody else on the wire")'


@pytest.fixture(autouse=True)
def nothing_left_behind() -> None:
    """The browser's driver keeps threads of its own until the module's end; consoles are processes."""


class Chat(BaseHTTPRequestHandler):
    """A page of another site, 127.0.0.1, with a link to the console, which is at localhost."""

    def __init__(self, link: str, *arguments: Any) -> None:
        self._link = link
        super().__init__(*arguments)

    def do_GET(self) -> None:
        page = f'<!doctype html><title>chat</title><a href="{self._link}">the robot</a>'.encode()
        self.send_response(200)
        self.send_header('Content-Type', 'text/html')
        self.send_header('Content-Length', str(len(page)))
        self.end_headers()
        self.wfile.write(page)

    def log_message(self, *_: object) -> None:
        pass


@pytest.fixture(scope='module')
def url() -> Iterator[str]:
    """The address that a console prints: it has the token."""
    pytest.importorskip('nicegui')
    stage = Stage('rmw_zenoh_cpp')
    yield stage.console('--token', TOKEN)[1]
    stage.close()


@pytest.fixture(scope='module')
def chat(url: str) -> Iterator[str]:
    """The address of the other site."""
    with ThreadingHTTPServer(('127.0.0.1', 0), partial(Chat, url)) as server:
        serving = Thread(target=server.serve_forever, kwargs={'poll_interval': 0.05})
        serving.start()
        yield f'http://127.0.0.1:{server.server_port}/'
        server.shutdown()
        serving.join()


@pytest.fixture
def page(chromium: Any) -> Iterator[Any]:
    """A tab of a browser that has been nowhere."""
    context = new_context(chromium, 1100, 700)
    yield context.new_page()
    context.close()


def test_a_link_of_another_site_opens_the_page_and_the_token_vanishes_each_time(
    page: Any, url: str, chat: str
) -> None:
    referers: list[str] = []
    page.on('request', lambda request: referers.append(request.headers.get('referer', '')))
    page.goto(chat)
    page.click('a')
    page.wait_for_selector(FIRST_WORDS)
    assert 'token' not in page.url
    picture(page, 'entrance')

    # The cookie is there now, and the link is followed once more; then it is typed, with another view.
    page.go_back()
    assert page.url == chat, 'the address with the token is in no history'
    page.click('a')
    page.wait_for_selector(FIRST_WORDS)
    assert 'token' not in page.url
    page.goto(f'{url}&view=logs#end')
    page.wait_for_selector('[data-view=logs].chosen')
    assert TOKEN not in page.url
    assert 'view=logs' in page.url
    assert not any(TOKEN in each for each in referers)

    # A form, a frame and a picture of the other site come in with no cookie.
    assert page.context.cookies()[0]['sameSite'] == 'Strict'
    page.goto(chat)
    refused = page.evaluate(
        """async (url) => {
          const frame = document.createElement('iframe');
          document.body.append(frame);
          const told = new Promise(done => { frame.onload = done; });
          frame.src = url;
          await told;
          const picture = new Image();
          const failed = new Promise(done => {
            picture.onerror = () => done(true);
            picture.onload = () => done(false); });
          picture.src = url;
          try { void frame.contentWindow.document.body; return 'the frame is ours'; }
          catch { return await failed; } }""",
        url,
    )
    assert refused is True


def test_a_page_opens_web_sockets_to_its_own_address_alone(page: Any, url: str, chat: str) -> None:
    page.goto(url)
    page.wait_for_selector(FIRST_WORDS)  # it came over the page's own web socket
    blocked = page.evaluate(
        """(elsewhere) => new Promise(done => {
          document.addEventListener('securitypolicyviolation', event => done(event.effectiveDirective));
          const socket = new WebSocket(elsewhere);
          socket.onopen = () => done('open');
          socket.onclose = () => setTimeout(() => done('tried'), 100); })""",
        chat.replace('http://127.0.0.1', 'ws://localhost'),
    )
    assert blocked == 'connect-src'
