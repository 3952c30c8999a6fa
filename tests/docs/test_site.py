"""The site: its links, how far its pages are, its names, what it looks like, and what its search finds."""

from __future__ import annotations

import os
import subprocess
import sys
import threading
from collections.abc import Iterator
from functools import partial
from html.parser import HTMLParser
from http.server import SimpleHTTPRequestHandler, ThreadingHTTPServer
from pathlib import Path
from typing import Any
from urllib.parse import quote, unquote, urldefrag

import pytest
from helpers.browser import chromium
from helpers.markdown import ROOT

pytest.importorskip('sphinx', reason='the checkout was not installed with its extra `site`')
pytestmark = [pytest.mark.long, pytest.mark.slow, pytest.mark.timeout(900)]

WIDTHS = (390, 768, 1440)


class _Links(HTMLParser):
    """The links of a page, and the names of its places."""

    def __init__(self, text: str) -> None:
        super().__init__()
        self.links: list[str] = []
        self.names: set[str] = set()
        self.feed(text)

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        given = dict(attrs)
        if tag == 'a' and given.get('href'):
            self.links.append(given['href'] or '')
        if given.get('id'):
            self.names.add(given['id'] or '')


@pytest.fixture(scope='module')
def site(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The site, built anew; Sphinx takes every warning for an error."""
    folder = tmp_path_factory.mktemp('site')
    command = [sys.executable, '-m', 'tools.site', str(folder)]
    done = subprocess.run(command, cwd=ROOT, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    return folder / 'html'


@pytest.fixture(scope='module')
def pages(site: Path) -> dict[Path, _Links]:
    return {page: _Links(page.read_text(encoding='utf-8')) for page in site.rglob('*.html')}


@pytest.fixture(scope='module')
def address(site: Path) -> Iterator[str]:
    """Where the site is served."""

    class Quiet(SimpleHTTPRequestHandler):
        def log_message(self, format: str, *args: object) -> None:
            pass

    class Server(ThreadingHTTPServer):
        def handle_error(self, request: object, client_address: object) -> None:
            pass  # the browser leaves a page before all of it has come

    with Server(('127.0.0.1', 0), partial(Quiet, directory=str(site))) as server:
        thread = threading.Thread(target=server.serve_forever)
        thread.start()
        yield f'http://127.0.0.1:{server.server_port}'
        server.shutdown()
        thread.join()


@pytest.fixture(scope='module')
def browser() -> Iterator[Any]:
    with chromium() as running:
        yield running


def test_every_link_leads_to_a_place_of_the_site(site: Path, pages: dict[Path, _Links]) -> None:
    wrong = []
    for page, found in pages.items():
        for link in found.links:
            if link.startswith(('http:', 'https:', 'mailto:')):
                continue
            path, place = urldefrag(unquote(link))
            target = (page.parent / path).resolve() if path else page
            if not target.exists() or (place and target in pages and place not in pages[target].names):
                wrong.append(f'{page.relative_to(site)}: {link}')
    assert wrong == []


def test_every_page_is_within_two_clicks(site: Path, pages: dict[Path, _Links]) -> None:
    reached = {site / 'index.html'}
    for _ in range(2):
        for page in sorted(reached):
            for link in pages[page].links:
                target = (page.parent / urldefrag(unquote(link))[0]).resolve()
                if target in pages:
                    reached.add(target)
    far = {page.relative_to(site).as_posix() for page in set(pages) - reached}
    assert far <= {'genindex.html', 'py-modindex.html', 'search.html'}  # the search's box leads to the last


def test_every_public_name_has_its_entry(site: Path, pages: dict[Path, _Links]) -> None:
    from tools.site.api import KITS, public_names

    for module in (*KITS, 'goalwire.errors'):
        names = pages[site / 'api' / f'{module}.html'].names
        public = public_names(module)
        assert len(public) >= 15
        assert [name for name in public if f'{module}.{name}' not in names] == []


@pytest.mark.parametrize('width', WIDTHS)
def test_pages_fit_a_screen(browser: Any, address: str, width: int) -> None:
    """Nothing is wider than the screen; the pictures are in GOALWIRE_SCREENSHOTS, to be looked at."""
    page = browser.new_page(viewport={'width': width, 'height': 900})
    for name in ('index', 'course/actions', 'reference/command-line', 'api/goalwire', 'commands/topic'):
        page.goto(f'{address}/{name}.html')
        assert page.evaluate('document.documentElement.scrollWidth') <= width, name
        if folder := os.environ.get('GOALWIRE_SCREENSHOTS'):
            page.screenshot(path=Path(folder, f'site-{name.replace("/", "-")}-{width}.png'))
    page.close()


def test_it_is_dark_where_the_reader_wants_it_dark(browser: Any, address: str) -> None:
    colours = []
    for scheme in ('light', 'dark'):
        page = browser.new_page(color_scheme=scheme)
        page.goto(f'{address}/index.html')
        colours.append(page.evaluate('getComputedStyle(document.body).backgroundColor'))
        page.close()
    assert colours[0] != colours[1]


@pytest.mark.parametrize('asked', ['QUESTIONS', 'WHERE_IS', 'ONE_THING'])
def test_the_search_answers_questions_with_the_right_page_first(
    browser: Any, address: str, asked: str
) -> None:
    from tools.site import questions

    chosen: dict[str, list[str]] = getattr(questions, asked)
    assert len(chosen) == 30
    wrong = {}
    page = browser.new_page()
    for question, right in chosen.items():
        page.goto(f'{address}/search.html?q={quote(question)}')
        first = page.locator('#search-results ul.search li a').first.get_attribute('href') or ''
        if not any(f'{name}.html' in first for name in right):
            wrong[question] = first
    page.close()
    assert len(wrong) <= 3, wrong
