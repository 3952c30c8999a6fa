"""goalwire on Cyclone DDS beside the real rclpy on Fast DDS, ROS 2's default: topics and services."""

from __future__ import annotations

import re
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
PEER, SERVER, CLIENT = (PROGRAMS / f'dds_{role}.py' for role in ('peer', 'server', 'client'))
ON_LOOPBACK = (
    '<CycloneDDS><Domain><General><Interfaces><NetworkInterface address="127.0.0.1"/></Interfaces></General>'
    '</Domain></CycloneDDS>'
)
"""Fast DDS names 127.0.0.1 alone where discovery is kept to this machine."""


def start(name: str, other: str, env: Mapping[str, str], python: Path) -> Program:
    return Program(PEER, name, other, env=env, python=python)


@pytest.mark.parametrize('first', ['ours', 'theirs'])
def test_topics_pass_both_ways_whoever_comes_first(real: Environment, tmp_path: Path, first: str) -> None:
    shared = isolated_env('rmw_cyclonedds_cpp', tmp_path)
    sides = {
        'ours': ('theirs', shared | {'CYCLONEDDS_URI': ON_LOOPBACK}, Path(sys.executable)),
        'theirs': ('ours', shared | {'RMW_IMPLEMENTATION': 'rmw_fastrtps_cpp'}, real.python),
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


@pytest.fixture
def ours(tmp_path: Path) -> dict[str, str]:
    """The environment of goalwire."""
    return isolated_env('rmw_cyclonedds_cpp', tmp_path) | {'CYCLONEDDS_URI': ON_LOOPBACK}


@pytest.fixture
def theirs(ours: dict[str, str]) -> dict[str, str]:
    """The environment of the real rclpy, in the same domain."""
    return ours | {'RMW_IMPLEMENTATION': 'rmw_fastrtps_cpp'}


def test_a_server_on_fast_dds_hears_nothing_of_a_client_that_may_not_call_it_and_all_of_one_that_may(
    real: Environment, ours: dict[str, str], theirs: dict[str, str]
) -> None:
    """So it gets no request in Cyclone's form, whose header it would take for the message."""
    with Program(SERVER, 'theirs', env=theirs, python=real.python) as server:
        server.expect('ready')
        with Program(CLIENT, 'ours', '1', '1', '0.1', env=ours) as client:
            client.expect('^not there')
            client.expect(
                r"'/set': no server answered \(its server runs on Fast DDS.*GOALWIRE_FASTDDS_SERVICES=1"
            )
            client.expect('right 0')
            client.succeed()
        assert 'asked' not in server.output
        with Program(
            CLIENT, 'ours', '50', '10', '2', env=ours | {'GOALWIRE_FASTDDS_SERVICES': '1'}
        ) as client:
            client.expect('^there')
            client.expect('right 58')
            client.succeed()
        server.send_signal(signal.SIGINT)
        server.wait()
        asked = re.findall(r'asked (\w+)', server.output)
    assert asked[-58:] == ['False', 'True'] * 29
    assert set(asked[:-58]) == {'True'}


def test_a_client_on_fast_dds_is_named_and_not_answered(
    real: Environment, ours: dict[str, str], theirs: dict[str, str]
) -> None:
    with Program(SERVER, 'ours', env=ours) as server:
        server.expect('ready')
        with Program(CLIENT, 'theirs', '30', '10', '1', env=theirs, python=real.python) as client:
            server.expect(
                r"service '/set': a request from Fast DDS .*\(of node '/theirs', .*rmw_cyclonedds_cpp"
            )
            client.kill()
        server.send_signal(signal.SIGINT)
        assert 'asked' not in server.succeed()
