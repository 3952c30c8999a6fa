"""Every test here starts and ends with logging as a fresh process has it."""

from __future__ import annotations

from collections.abc import Iterator

import pytest

from goalwire import logging
from goalwire.logging import LogRecord, configuration

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


@pytest.fixture
def records() -> Iterator[list[LogRecord]]:
    """Whatever is logged during the test."""
    seen: list[LogRecord] = []
    with logging.add_sink(seen.append):
        yield seen
