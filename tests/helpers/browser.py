"""A headless Chromium, the system's."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

import pytest

from tools.console_picture import CHROMIUM, FLAGS


@contextmanager
def chromium() -> Iterator[Any]:
    """Run it for as long as the block lasts; the test is skipped where there is none."""
    playwright = pytest.importorskip('playwright.sync_api')
    if CHROMIUM is None:
        pytest.skip('there is no Chromium here')
    with playwright.sync_playwright() as driver:
        browser = driver.chromium.launch(executable_path=CHROMIUM, args=FLAGS)
        yield browser
        browser.close()
