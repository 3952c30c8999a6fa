"""Kill -9 at random points: what the writing of a recorder loses, and whether the file opens everywhere."""

from __future__ import annotations

import json
import subprocess
import sys
from pathlib import Path

import pytest

PROGRAM = Path(__file__).parent / 'programs' / 'kills.py'
LOST_S = 1.5
"""A second, and what a busy machine takes on top of the half second after which a flush is due."""


def assert_kills_cost_little(folder: Path, count: int, seed: int) -> None:
    pytest.importorskip('rosbags')
    command = [sys.executable, str(PROGRAM), str(folder), str(count), str(seed)]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    kills = [json.loads(line) for line in done.stdout.splitlines()]
    assert len(kills) == count
    for kill in kills:
        assert kill['gapless'], kill
        assert kill['lost_s'] is None or kill['lost_s'] < LOST_S, kill
        if kill['whole']:
            assert kill['rosbags'] == kill['messages'], kill


@pytest.mark.slow
def test_a_kill_costs_a_second_at_most(tmp_path: Path) -> None:
    assert_kills_cost_little(tmp_path, 6, 1)


@pytest.mark.long
@pytest.mark.slow
@pytest.mark.timeout(900)
def test_two_hundred_kills_cost_a_second_at_most(tmp_path: Path) -> None:
    assert_kills_cost_little(tmp_path, 200, 2)
