"""A node of the asyncio API that outlives its loop gives the loop's descriptors back."""

from __future__ import annotations

import sys

import pytest
from helpers.process_life import PROGRAMS, WIRES, world_on
from helpers.programs import programs_in

pytestmark = [
    pytest.mark.slow,
    pytest.mark.skipif(sys.platform != 'linux', reason='looks in /proc'),
    pytest.mark.timeout(400),
]


@pytest.mark.parametrize('session', WIRES)
def test_fifty_closed_loops_hold_no_more_descriptors_than_one(session: str) -> None:
    with programs_in(world_on(session), PROGRAMS) as start, start('closed_loops') as program:
        assert program.succeed(100).splitlines()[-1:] == ['good']
