"""The endurance run: the things that it counts as left behind, and that a part of it runs."""

from __future__ import annotations

import subprocess
import sys

import pytest
from helpers.markdown import ROOT

from benchmarks.endurance.__main__ import PARTS, problems
from benchmarks.line import Figures

AS_BEFORE: Figures = {
    'maker MiB before': 28.0,
    'maker MiB': 28.5,
    'maker threads': 0,
    'maker files': -1,
    'nodes left': 0,
    'first ninth CPU s': 1.0,
    'last ninth CPU s': 1.2,
}


def told(**changed: float) -> list[str]:
    figures = AS_BEFORE | {name.replace('_', ' '): figure for name, figure in changed.items()}
    return list(problems(PARTS['nodes'], 1000, figures, timed=True))


def test_what_is_as_before_is_no_problem() -> None:
    assert told() == []


@pytest.mark.parametrize(
    ('changed', 'said'),
    [
        ({'maker_MiB': 84.0}, 'maker MiB: 56.0 more'),
        ({'maker_threads': 1}, '1 more maker threads'),
        ({'maker_files': 2}, '2 more maker files'),
        ({'nodes_left': 3}, '3 nodes are left'),
        ({'last_ninth_CPU_s': 3.0}, 'the last ninth CPU s went from 1.0 to 3.0'),
    ],
)
def test_what_is_left_or_grows_is_told(changed: dict[str, float], said: str) -> None:
    assert told(**changed) == [said]


@pytest.mark.slow
@pytest.mark.timeout(300)
def test_two_processes_see_each_others_publishers_whole_and_none_of_one_that_is_killed() -> None:
    """4000 in each at its full size."""
    done = subprocess.run(
        [sys.executable, '-m', 'benchmarks.endurance', '--scale', '0.025', '--untimed', 'publishers'],
        cwd=ROOT,
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 0, done.stdout + done.stderr
    assert 'publishers 100: ' in done.stdout
    assert 'north sees rightly 100, south sees rightly 100' in done.stdout
