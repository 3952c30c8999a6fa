"""The way in which all the small programs end."""

from __future__ import annotations

import signal
import sys

import pytest
from helpers.processes import Program

SIGNALLED_EARLY = """
import os, signal, sys
from rclpy.node import Node
from goalwire.apps.programs.running import spin

def make_node():
    os.kill(os.getpid(), int(sys.argv[1]))
    return Node('early')

sys.exit(spin(make_node, ['program']))
"""


@pytest.mark.skipif(sys.platform == 'win32', reason='signals of POSIX')
@pytest.mark.parametrize('number', [signal.SIGINT, signal.SIGTERM])
def test_a_signal_that_comes_while_the_node_is_made_ends_a_program_in_order(
    isolated: dict[str, str], number: signal.Signals
) -> None:
    with Program(SIGNALLED_EARLY, str(int(number)), env=isolated) as program:
        assert program.wait() == 0
        assert program.output == ''
