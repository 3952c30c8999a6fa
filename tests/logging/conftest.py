"""Every test here starts and ends with logging as a fresh process has it."""

from __future__ import annotations

from collections.abc import Iterator

import pytest

from goalwire import logging
from goalwire.logging import configuration

RCUTILS = (
    'RCUTILS_COLORIZED_OUTPUT',
    'RCUTILS_CONSOLE_OUTPUT_FORMAT',
    'RCUTILS_LOGGING_BUFFERED_STREAM',
    'RCUTILS_LOGGING_USE_STDOUT',
)


@pytest.fixture(autouse=True)
def fresh_logging(monkeypatch: pytest.MonkeyPatch) -> Iterator[None]:
    for name in RCUTILS:
        monkeypatch.delenv(name, raising=False)
    logging.shutdown()
    yield
    while configuration.users():
        configuration.release()
    logging.shutdown()
