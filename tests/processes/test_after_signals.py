"""A program that was told to end commands nobody any more, whatever it catches: both wires, both fronts."""

from __future__ import annotations

import signal
import sys

import pytest
from helpers.programs import Start
from helpers.wires import DDS, require

pytestmark = [pytest.mark.slow, pytest.mark.skipif(sys.platform == 'win32', reason='signals of POSIX')]


@pytest.mark.parametrize('transport', ['rmw_zenoh_cpp', DDS])
@pytest.mark.parametrize('front', ['rclpy', 'asyncio'])
def test_nothing_is_sent_after_sigterm(start: Start, front: str, transport: str) -> None:
    require(transport)
    robot = start('commanded', RMW_IMPLEMENTATION=transport)
    robot.expect('ready')
    for kind in ('publish', 'call', 'goal'):
        commander = start('commander', front, kind, 'stubborn', RMW_IMPLEMENTATION=transport)
        robot.expect(f'moving {kind}')
        commander.send_signal(signal.SIGTERM)
        assert "0 of 200 late commands went through; ['ShutDownBySignalError']" in commander.succeed()
    robot.send_signal(signal.SIGINT)
    assert 'LATE' not in robot.succeed()


ON_ZENOH = [pytest.param(kind, 'rmw_zenoh_cpp') for kind in ('publish', 'call', 'goal')]
ON_DDS = [
    pytest.param(kind, DDS, marks=() if kind == 'call' else pytest.mark.long)
    for kind in ('publish', 'call', 'goal')
]
"""The node refuses before a wire is asked: on DDS one kind of command shows it in each run."""


@pytest.mark.parametrize('front', ['rclpy', 'asyncio'])
@pytest.mark.parametrize(('kind', 'transport'), ON_ZENOH + ON_DDS)
def test_a_loop_that_catches_nothing_ends(start: Start, front: str, transport: str, kind: str) -> None:
    require(transport)
    robot = start('commanded', RMW_IMPLEMENTATION=transport)
    robot.expect('ready')
    commander = start('commander', front, kind, 'plain', RMW_IMPLEMENTATION=transport)
    robot.expect(f'moving {kind}')
    commander.send_signal(signal.SIGTERM)
    assert commander.wait() == 1
    assert 'Traceback' not in commander.output, 'the signal has ended the program'
    robot.send_signal(signal.SIGINT)
    assert 'LATE' not in robot.succeed()
