"""A hundred and more mistakes of beginners: each is told once, at its line, soon, and with what to write."""

from __future__ import annotations

import re
from collections.abc import Iterator
from pathlib import Path

import pytest
from helpers.forking import ForkServer
from helpers.isolation import isolated_env
from mistakes.catalog import Mistake, read_all
from mistakes.running import PRELOADED, count, run

import goalwire

MISTAKES = read_all()
_OURS = rf'File "(<goalwire\b|{re.escape(str(Path(goalwire.__file__).parent))}/)'
"""A frame of the library's, or of code that it has made."""
_BUSY_S = 5.0
"""What a busy machine may add to the time until something is told."""


@pytest.fixture(scope='module')
def server() -> Iterator[ForkServer]:
    with ForkServer(PRELOADED, isolated_env('rmw_zenoh_cpp')) as started:
        yield started


@pytest.mark.parametrize('mistake', MISTAKES, ids=lambda mistake: mistake.name)
def test_a_mistake_is_told(mistake: Mistake, server: ForkServer, tmp_path: Path) -> None:
    told = run(mistake, tmp_path, isolated_env('rmw_zenoh_cpp'), server)
    assert told.after is not None, f'it was not told: {mistake.says}\n{told.output}'
    assert told.after < mistake.within + _BUSY_S, told.output
    assert '(killed' not in told.output
    assert _is_at(mistake.place, told.output), f'{mistake.place} is not named\n{told.output}'
    assert not re.search(_OURS, told.output), f'frames of ours\n{told.output}'
    assert count(mistake.says, told.output) == 1, told.output
    assert not mistake.never_says or not count(mistake.never_says, told.output), told.output


def test_there_are_a_hundred() -> None:
    assert len(MISTAKES) >= 100
    assert all(mistake.says and mistake.title.endswith('.') for mistake in MISTAKES)


def _is_at(place: str, output: str) -> bool:
    """Whether a place is named, as warnings and as tracebacks do."""
    file, colon, line = place.rpartition(':')
    return place in output or (bool(colon) and f'{file}", line {line}' in output)
