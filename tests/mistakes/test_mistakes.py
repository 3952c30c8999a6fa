"""A hundred and more mistakes of beginners: each is told once, at its line, soon, and with what to write."""

from __future__ import annotations

import re
from collections.abc import Iterator
from pathlib import Path

import pytest
from helpers.forking import ForkServer
from helpers.isolation import isolated_env
from mistakes.catalog import Mistake, read_all
from mistakes.running import PRELOADED, Told, count, run

import goalwire

MISTAKES = read_all()
_OURS = rf'File "(<goalwire\b|{re.escape(str(Path(goalwire.__file__).parent))}/)'
"""A frame of the library's, or of code that it has made."""
_BUSY_S = 5.0
"""The seconds that a busy machine may add to the time until something is told."""
_RUNS = 3
"""How often a program may be late. One that waits too long is late each time; a busy machine is not."""


@pytest.fixture(scope='module')
def server() -> Iterator[ForkServer]:
    with ForkServer(PRELOADED, isolated_env('rmw_zenoh_cpp')) as started:
        first = started.start('pass', [], environment=isolated_env('rmw_zenoh_cpp'))
        assert first.stdin is not None
        assert first.stdout is not None
        with first.stdin, first.stdout:
            first.wait()  # now it has imported everything
        yield started


def run_in_time(mistake: Mistake, server: ForkServer, folder: Path) -> Told:
    """Run a program that tells in time, if need be several times."""
    told = Told('', None)
    for number in range(_RUNS):
        told = run(mistake, folder / str(number), isolated_env('rmw_zenoh_cpp'), server)
        assert told.after is not None, f'it was not told: {mistake.says}\n{told.output}'
        if told.after < mistake.within + _BUSY_S:
            return told
    raise AssertionError(f'it was late {_RUNS} times, {told.after} s at last\n{told.output}')


@pytest.mark.parametrize('mistake', MISTAKES, ids=lambda mistake: mistake.name)
def test_a_mistake_is_told(mistake: Mistake, server: ForkServer, tmp_path: Path) -> None:
    told = run_in_time(mistake, server, tmp_path)
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
