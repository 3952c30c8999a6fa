"""A signal's handler that publishes and calls while its thread is just at it: all arrives, in order."""

from __future__ import annotations

import sys

import pytest
from helpers.programs import Start
from helpers.wires import DDS, require

pytestmark = pytest.mark.skipif(sys.platform == 'win32', reason='signals of POSIX')

COUNT = 200
WIRES = {'ours': ('rmw_zenoh_cpp', 'native'), 'eclipse': ('rmw_zenoh_cpp', 'eclipse'), 'dds': (DDS, '')}


@pytest.mark.parametrize('sessions_of', WIRES)
def test_what_a_handler_publishes_and_asks_arrives(start: Start, sessions_of: str) -> None:
    transport, sessions = WIRES[sessions_of]
    require(transport)
    variables = {'RMW_IMPLEMENTATION': transport, 'GOALWIRE_ZENOH': sessions}
    listener = start('interrupted', 'listener', COUNT, **variables)
    listener.expect('ready')
    talker = start('interrupted', 'talker', COUNT, **variables)
    assert 'calls of the handler were answered' in talker.succeed()
    output = listener.succeed()
    told = [
        'shared of main',
        'shared of handler',
        'lasting of main',
        'lasting of handler',
        'handlers of handler',
    ]
    assert output.splitlines()[-5:] == [f'{each}: all in order' for each in told]
