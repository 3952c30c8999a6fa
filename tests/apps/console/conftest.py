"""Stages for consoles, and a browser."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import Any

import pytest
from helpers.console import CHROMIUM, Stage
from helpers.page import new_context

from tools import console_picture


@pytest.fixture
def stage(transport_name: str) -> Iterator[Stage]:
    """A world of its own."""
    pytest.importorskip('nicegui')
    made = Stage(transport_name)
    yield made
    made.close()


@pytest.fixture
def transport_name() -> str:
    """Consoles are processes: they need a wire. Modules may choose another."""
    return 'rmw_zenoh_cpp'


@pytest.fixture(scope='module')
def chromium() -> Iterator[Any]:
    """A headless Chromium, the system's; the test is skipped where there is none."""
    playwright = pytest.importorskip('playwright.sync_api')
    if CHROMIUM is None:
        pytest.skip('there is no Chromium here')
    with playwright.sync_playwright() as driver:
        browser = driver.chromium.launch(executable_path=CHROMIUM, args=console_picture.FLAGS)
        yield browser
        browser.close()


@pytest.fixture
def open_page(chromium: Any) -> Iterator[Callable[[str], Any]]:
    """`open_page(url)` opens the console in a browser of its own; an error in the page fails the test."""
    errors: list[str] = []
    contexts = []

    def open_one(url: str) -> Any:
        context = new_context(chromium, 1100, 700, accept_downloads=True)
        contexts.append(context)
        page = context.new_page()
        page.on('pageerror', lambda error: errors.append(str(error)))
        page.on('request', lambda request: _only_from(url, request.url, errors))
        page.goto(url)
        return page

    yield open_one
    for context in contexts:
        context.close()
    assert errors == [], 'errors in the page'


def _only_from(url: str, asked: str, errors: list[str]) -> None:
    origin = url.split('?', maxsplit=1)[0].rstrip('/')
    if not asked.startswith((origin, 'data:', 'blob:', 'ws://localhost')):
        errors.append(f'the page asked another site: {asked}')
