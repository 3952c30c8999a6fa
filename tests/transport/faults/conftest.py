"""Two sides on the memory transport, the faults between them, and a clock set by hand."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TypeAlias

import pytest
from helpers.hand_clock import HandClock
from helpers.wire import BARE, Side

from goalwire.transport.contract import SessionOptions
from goalwire.transport.faults import Faults
from goalwire.transport.memory import TRANSPORT

Sides: TypeAlias = tuple[Side, Side]


@pytest.fixture
def clock() -> HandClock:
    return HandClock()


@pytest.fixture
def faults(clock: HandClock) -> Faults:
    """No fault yet, in the time of `clock`."""
    return Faults(seed=7, clock=clock)


@pytest.fixture
def sides(faults: Faults) -> Iterator[Sides]:
    """The nodes /alpha and /beta in sessions of their own."""
    transport = faults.over(TRANSPORT)
    sessions = [transport.open(SessionOptions(domain_id=232)) for _ in range(2)]
    yield Side(sessions[0], 'alpha', BARE), Side(sessions[1], 'beta', BARE)
    for session in sessions:
        session.close()
