"""The isolated environments themselves."""

from __future__ import annotations

import socket
from itertools import count

import pytest
from helpers import isolation
from helpers.fresh import clean_environment
from helpers.isolation import free_port, fresh_domain, isolated_env
from helpers.processes import Program

from goalwire.transport.zenoh.rendezvous import RENDEZVOUS


def test_two_environments_share_neither_domain_nor_port() -> None:
    first, second = isolated_env('goalwire_memory'), isolated_env('goalwire_memory')
    for name in ('ROS_DOMAIN_ID', 'GOALWIRE_ROUTER_PORT'):
        assert first[name] != second[name]


def test_nothing_of_a_sourced_ros_2_is_inherited(monkeypatch: pytest.MonkeyPatch) -> None:
    for name in ('AMENT_PREFIX_PATH', 'ZENOH_CONFIG_OVERRIDE', 'ROS_DISTRO', 'CYCLONEDDS_URI'):
        monkeypatch.setenv(name, 'the machine has one')
    monkeypatch.setenv('ROS_DOMAIN_ID', '999')
    env = isolated_env('rmw_zenoh_cpp')
    assert 'the machine has one' not in env.values()
    assert 0 < int(env['ROS_DOMAIN_ID']) <= 230
    assert env['RMW_IMPLEMENTATION'] == 'rmw_zenoh_cpp'


def test_whose_sessions_are_tested_reaches_the_programs_of_a_test(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv('GOALWIRE_ZENOH', 'native')
    for environment in (isolated_env('rmw_zenoh_cpp'), clean_environment()):
        with Program("import os; print(os.environ['GOALWIRE_ZENOH'])", env=environment) as program:
            assert program.succeed() == 'native'


def test_a_port_somebody_listens_on_is_not_handed_out(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(isolation, '_ports', count())
    taken = free_port()
    with socket.create_server(('127.0.0.1', taken)):
        monkeypatch.setattr(isolation, '_ports', count())
        assert free_port() != taken


def test_a_port_that_was_left_to_another_router_is_not_handed_out(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(isolation, '_ports', count())
    left = free_port()
    monkeypatch.setattr(RENDEZVOUS, '_left', {left})
    monkeypatch.setattr(isolation, '_ports', count())
    assert free_port() != left


def test_another_test_run_gets_other_domains() -> None:
    mine = fresh_domain()
    source = 'from helpers.isolation import fresh_domain; print({fresh_domain() for _ in range(10)})'
    with Program(f'import sys; sys.path[:0] = {__import__("sys").path!r}; {source}') as program:
        assert str(mine) not in program.succeed().strip('{}').split(', ')
