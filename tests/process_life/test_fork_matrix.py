"""Children started in nine ways, at five times, which end in six ways: both sides are looked at each time.

programs/matrix.py runs the cases in one parent process. The suite meets a diagonal of them, another one on
each wire; `make long` meets them all.
"""

from __future__ import annotations

import sys
from pathlib import Path

import pytest
from helpers.process_life import PROGRAMS, WIRES, world_on
from helpers.processes import Program
from helpers.programs import programs_in

pytestmark = [
    pytest.mark.slow,
    pytest.mark.skipif(sys.platform != 'linux', reason='uses pidfd, and looks in /proc'),
]

DIAGONAL, ALL = 45, 270
ECLIPSES_SOCKETS = {'KEPT_SOCKETS': '1'}
"""Sockets of eclipse-zenoh's own sessions stay open in forked children; only it could close them."""


def failures(session: str, folder: Path, *cases: str, patience: float) -> list[str]:
    """Run cases on a wire; return what was not right, and last how many cases that were."""
    env = world_on(session) | (ECLIPSES_SOCKETS if session == 'eclipse' else {})
    with programs_in(env, PROGRAMS) as start:
        beside = start('counts_calls')
        beside.expect('^ready$')
        with Program(PROGRAMS / 'matrix.py', *cases, env=env, cwd=folder) as matrix:
            matrix.wait(patience)
            lines = matrix.output.splitlines()
    return lines[lines.index('--') + 1 :] if '--' in lines else lines


@pytest.mark.timeout(400)
@pytest.mark.parametrize(('number', 'session'), list(enumerate(WIRES)))
def test_a_diagonal_of_children(number: int, session: str, tmp_path: Path) -> None:
    assert failures(session, tmp_path, 'some', str(number), patience=180) == [f'{DIAGONAL} cases', 'good']


@pytest.mark.long
@pytest.mark.timeout(900)
@pytest.mark.parametrize('session', WIRES)
def test_all_children(session: str, tmp_path: Path) -> None:
    assert failures(session, tmp_path, 'all', patience=800) == [f'{ALL} cases', 'good']
