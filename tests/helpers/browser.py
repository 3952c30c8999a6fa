"""A headless Chromium, the system's."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import ExitStack, contextmanager
from typing import Any

import pytest

from tools.console_picture import CHROMIUM, FLAGS, ROOT

_COMPILED = ROOT / '.pytest_cache' / 'node'
"""Where the browser's driver, which runs on Node.js, keeps its code compiled: it starts in two thirds of
the time."""

_SHORT_LIVED = '--js-flags=--no-opt --no-maglev'
"""To optimise the code of a page that lives for seconds takes a twentieth of its time, and saves less."""


@contextmanager
def chromium() -> Iterator[Any]:
    """Run Chromium for as long as the block lasts; the test is skipped if there is none."""
    playwright = pytest.importorskip('playwright.sync_api')
    if CHROMIUM is None:
        pytest.skip('there is no Chromium here')
    with ExitStack() as ends:
        with pytest.MonkeyPatch.context() as environment:
            environment.setenv('NODE_COMPILE_CACHE', str(_COMPILED))
            driver = ends.enter_context(playwright.sync_playwright())
        browser = driver.chromium.launch(executable_path=CHROMIUM, args=[*FLAGS, _SHORT_LIVED])
        yield browser
        browser.close()
