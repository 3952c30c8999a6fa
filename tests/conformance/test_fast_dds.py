"""goalwire beside the real rclpy on Fast DDS, ROS 2's default: topics, whoever comes first."""

from __future__ import annotations

import signal
import sys
from collections.abc import Mapping
from contextlib import ExitStack
from pathlib import Path

import pytest
from helpers.environments import Environment
from helpers.isolation import isolated_env
from helpers.processes import Program

pytestmark = pytest.mark.slow

PROGRAMS = Path(__file__).parents[1] / 'interop' / 'programs'
PEER = PROGRAMS / 'dds_peer.py'


def start(name: str, other: str, env: Mapping[str, str], python: Path) -> Program:
    return Program(PEER, name, other, env=env, python=python)


@pytest.mark.parametrize('first', ['ours', 'theirs'])
def test_topics_pass_both_ways_whoever_comes_first(real: Environment, tmp_path: Path, first: str) -> None:
    shared = isolated_env('rmw_fastrtps_cpp', tmp_path)
    sides = {
        'ours': ('theirs', shared, Path(sys.executable)),
        'theirs': ('ours', shared, real.python),
    }
    second = sides[first][0]
    with ExitStack() as running:
        programs = {name: running.enter_context(start(name, *sides[name])) for name in (first, second)}
        for name, program in programs.items():
            other = sides[name][0]
            program.expect(rf'text grüße von {other}$')
            program.expect(r'numbers \[0\.5, -1\.25, 3e\+300\]')
            program.expect(r'nodes ours theirs$')
        for program in programs.values():
            program.send_signal(signal.SIGINT)
        assert programs['ours'].wait() == 0
