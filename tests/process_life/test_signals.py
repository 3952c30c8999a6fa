"""Signals of a program that has its own ideas about them: each a program of its own, on Zenoh and on DDS."""

from __future__ import annotations

import importlib.util
import signal
import sys
from collections.abc import Iterator
from itertools import product
from pathlib import Path

import pytest
from helpers.isolation import isolated_env
from helpers.programs import Start, programs_in
from helpers.wires import DDS, require

if sys.platform == 'win32':
    pytest.skip('POSIX signals', allow_module_level=True)


@pytest.fixture(params=['rmw_zenoh_cpp', DDS])
def start(request: pytest.FixtureRequest) -> Iterator[Start]:
    """A function that starts a program of this folder, on each wire."""
    require(request.param)
    with programs_in(isolated_env(request.param), Path(__file__).parent / 'programs') as start:
        yield start


EACH_RUN = [
    ('SIGINT', 'stays', 'spin'),
    ('SIGINT', 'restores', 'sleep'),
    ('SIGTERM', 'stays', 'sleep'),
    ('SIGTERM', 'restores', 'spin'),
]
"""Each signal with each handler, with each way of waiting; `make long` runs all that can be combined."""
COMBINED = [
    pytest.param(*each, marks=() if each in EACH_RUN else pytest.mark.long)
    for each in product(['SIGINT', 'SIGTERM'], ['stays', 'restores'], ['spin', 'sleep'])
]


@pytest.mark.parametrize(('number', 'how', 'wait'), COMBINED)
def test_a_later_handler_finds_the_context_open(start: Start, number: str, how: str, wait: str) -> None:
    robot = start('safe_stop', number, how, wait)
    robot.expect('ready')
    robot.send_signal(signal.Signals[number])
    assert robot.succeed() == 'ready\nstopped, ok True'


def test_signals_are_passed_on_to_the_wakeup_descriptor_of_before(start: Start) -> None:
    number = int(signal.SIGUSR1)
    assert start('wakeup_descriptor', 'no').succeed().splitlines() == [
        f'before init: [{number}]',
        f'after init: [{number}]',
        f'after shutdown: [{number}]',
        'its place: True',
    ]


def test_a_strangers_file_under_a_closed_number_gets_nothing(start: Start) -> None:
    assert start('wakeup_descriptor', 'yes').succeed().splitlines()[2:] == [
        'the number is used again: True',
        'strangers get: data',
        'its place: -1',
    ]


@pytest.mark.skipif(importlib.util.find_spec('trio') is None, reason='trio is not installed')
def test_trio_may_outlive_ros(start: Start) -> None:
    assert start('trio_ends_later').succeed() == 'interrupted, ok False'
