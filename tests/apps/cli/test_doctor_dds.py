"""ros2 doctor beside robots on another wire: whose they are, and which variable reaches them."""

from __future__ import annotations

import json
from collections.abc import Callable, Iterator
from contextlib import ExitStack
from pathlib import Path

import pytest
from helpers.command_line import CommandLine
from helpers.isolation import isolated_env
from helpers.processes import Program

from goalwire.errors import TransportError
from goalwire.transport.dds.cyclone.library import find_library

PROGRAM = Path(__file__).parent / 'programs' / 'lonely.py'
ZENOH, FAST_DDS, CYCLONE = 'rmw_zenoh_cpp', 'rmw_fastrtps_cpp', 'rmw_cyclonedds_cpp'
REACHES = 'does not reach them: RMW_IMPLEMENTATION={} does'


@pytest.fixture
def place() -> dict[str, str]:
    """An environment for one test's programs, whichever wire each of them speaks."""
    return isolated_env(ZENOH)


@pytest.fixture
def run(place: dict[str, str]) -> Iterator[Callable[..., None]]:
    """A function that starts a robot's program on a wire."""
    with ExitStack() as stack:

        def run_one(rmw: str, **variables: str) -> None:
            env = place | {'RMW_IMPLEMENTATION': rmw} | variables
            stack.enter_context(Program(PROGRAM, env=env)).expect('^ready$')

        yield run_one


def _checks(place: dict[str, str], rmw: str) -> dict[str, dict[str, object]]:
    """Return what doctor has found, by the name of each check."""
    out = CommandLine(place)('doctor', '--json', '--no-self-test', RMW_IMPLEMENTATION=rmw).out
    return {check['name']: check for line in out.splitlines() for check in [json.loads(line)]}


def test_on_zenoh_it_names_the_variable_that_reaches_robots_on_dds(
    place: dict[str, str], run: Callable[..., None]
) -> None:
    run(FAST_DDS)
    run(FAST_DDS)
    check = _checks(place, ZENOH)[f'DDS, domain {place["ROS_DOMAIN_ID"]}']
    assert check['found'] == 'participants: 2 of goalwire'
    assert check['advice'] == f'{ZENOH} {REACHES.format(FAST_DDS)}'
    assert check['is_well'], 'nothing is wrong with this machine'


def test_the_vendor_decides_which_variable_it_is(place: dict[str, str], run: Callable[..., None]) -> None:
    try:
        find_library()
    except TransportError as error:
        pytest.skip(str(error))
    run(CYCLONE, GOALWIRE_DDS='cyclone')
    check = _checks(place, ZENOH)[f'DDS, domain {place["ROS_DOMAIN_ID"]}']
    assert check['found'] == 'participants: 1 of Cyclone DDS'
    assert check['advice'] == f'{ZENOH} {REACHES.format(CYCLONE)}'


def test_on_dds_it_counts_them_and_needs_no_advice(place: dict[str, str], run: Callable[..., None]) -> None:
    run(CYCLONE)
    check = _checks(place, FAST_DDS)[f'DDS, domain {place["ROS_DOMAIN_ID"]}']
    assert (check['found'], check['advice']) == ('participants: 1 of goalwire', '')


def test_on_dds_it_names_the_variable_that_reaches_robots_on_zenoh(
    place: dict[str, str], run: Callable[..., None]
) -> None:
    run(ZENOH)
    check = _checks(place, FAST_DDS)[f'Zenoh, port {place["GOALWIRE_ROUTER_PORT"]}']
    assert check['found'] == 'a router answers'
    assert check['advice'] == f'its programs are not reached on DDS: RMW_IMPLEMENTATION={ZENOH} reaches them'


def test_where_nobody_is_it_says_so_on_dds_alone(place: dict[str, str]) -> None:
    name = f'DDS, domain {place["ROS_DOMAIN_ID"]}'
    assert name not in _checks(place, ZENOH)
    assert _checks(place, FAST_DDS)[name]['found'] == 'nobody announces itself'
