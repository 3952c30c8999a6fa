"""Stages for consoles, and a browser."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import Any

import pytest
from helpers import browser
from helpers.console import Stage
from helpers.page import new_context


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
    """The system's Chromium, headless; the test is skipped if there is none."""
    with browser.chromium() as running:
        yield running


@pytest.fixture(scope='module')
def window(chromium: Any) -> Iterator[Any]:
    """A window of the browser, for the tabs of all tests: to open one takes longer than to open a page.

    Each console has a port of its own, so its pages find nothing that the pages of another one kept.
    """
    context = new_context(chromium, 1100, 700, accept_downloads=True)
    yield context
    context.close()


@pytest.fixture
def open_page(window: Any) -> Iterator[Callable[[str], Any]]:
    """`open_page(url)` opens the console in a tab of its own; an error in the page fails the test."""
    errors: list[str] = []
    pages = []

    def open_one(url: str) -> Any:
        page = window.new_page()
        pages.append(page)
        page.on('pageerror', lambda error: errors.append(str(error)))
        page.on('request', lambda request: _only_from(url, request.url, errors))
        page.goto(url)
        return page

    yield open_one
    for page in pages:
        page.close()
    assert errors == [], 'errors in the page'


def _only_from(url: str, asked: str, errors: list[str]) -> None:
    origin = url.split('?', maxsplit=1)[0].rstrip('/')
    if not asked.startswith((origin, 'data:', 'blob:', 'ws://localhost')):
        errors.append(f'the page asked another site: {asked}')
