"""How programs end: on Ctrl-C and SIGTERM with the codes of rclpy, and cleanly in the middle of traffic."""

from __future__ import annotations

import os
import signal
import sys

import pytest
from helpers.programs import Start
from helpers.wires import DDS, require

pytestmark = pytest.mark.skipif(sys.platform == 'win32', reason='signals of POSIX')

SOME_PROGRAMS = pytest.mark.timeout(400)
"""Many programs one after the other, on a machine that is busy."""
TIMES = int(os.environ.get('GOALWIRE_TEST_EXITS', '3'))
"""How often a program leaves in each way on each wire; GOALWIRE_TEST_EXITS=20 makes it more."""
wires = pytest.mark.parametrize('transport', ['rmw_zenoh_cpp', DDS])


@pytest.mark.parametrize('number', [signal.SIGINT, signal.SIGTERM])
@pytest.mark.parametrize('program', ['add_server', 'fibonacci_server', 'idle'])
def test_a_program_that_guards_its_spin_ends_with_code_0(
    start: Start, program: str, number: signal.Signals
) -> None:
    running = start(program)
    running.expect('ready')
    running.send_signal(number)
    output = running.succeed()
    assert output == 'ready\nstopped'


@pytest.mark.parametrize(('number', 'code'), [(signal.SIGINT, -signal.SIGINT), (signal.SIGTERM, 1)])
def test_a_program_that_guards_nothing_ends_as_under_rclpy_but_quietly(
    start: Start, number: signal.Signals, code: int
) -> None:
    running = start('bare_spin')
    running.expect('ready')
    running.send_signal(number)
    assert running.wait() == code
    assert running.output == 'ready'


@pytest.mark.slow
@SOME_PROGRAMS
@wires
@pytest.mark.parametrize('how', ['nothing closed', 'sys.exit', 'shutdown'])
def test_leaving_in_the_middle_of_traffic_is_clean_every_time(start: Start, how: str, transport: str) -> None:
    require(transport)
    flood = start('flood', RMW_IMPLEMENTATION=transport)
    flood.expect('ready')
    codes = []
    for _ in range(TIMES):
        leaving = start('leave', how, RMW_IMPLEMENTATION=transport)
        codes.append(leaving.wait())
        assert 'Traceback' not in leaving.output
    assert codes == [0] * TIMES
    flood.send_signal(signal.SIGINT)
    flood.succeed()


@pytest.mark.slow
@SOME_PROGRAMS
@wires
def test_ctrl_c_in_the_middle_of_traffic_is_clean_every_time(start: Start, transport: str) -> None:
    require(transport)
    start('flood', RMW_IMPLEMENTATION=transport).expect('ready')
    codes = []
    for _ in range(TIMES):
        leaving = start('leave', 'interrupted', RMW_IMPLEMENTATION=transport)
        leaving.expect('in the middle of traffic')
        leaving.send_signal(signal.SIGINT)
        codes.append(leaving.wait())
    assert codes == [-signal.SIGINT] * TIMES
