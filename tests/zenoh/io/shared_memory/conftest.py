"""Two sessions that share memory."""

from __future__ import annotations

from collections.abc import Iterator

import pytest
from helpers.patience import wait_for
from helpers.zenoh_memory import WITH_OWN, OpenPair
from helpers.zenoh_sides import Ours, Side, address

from goalwire.zenoh.io.settings import MemorySettings


@pytest.fixture
def sides() -> Iterator[list[Side]]:
    """The sides, which are closed after the test, the last first; closing leaves no segment behind."""
    opened: list[Side] = []
    yield opened
    for side in reversed(opened):
        side.close()


@pytest.fixture
def open_pair(sides: list[Side]) -> OpenPair:
    """Open two linked sessions of goalwire's with these settings of memory; the first listens."""

    def open_both(one: MemorySettings = WITH_OWN, other: MemorySettings = WITH_OWN) -> tuple[Ours, Ours]:
        where = address()
        listener = Ours('peer', listen=(where,), memory=one)
        sides.append(listener)
        connector = Ours('peer', connect=(where,), memory=other)
        sides.append(connector)
        wait_for(lambda: connector.id in listener.links() and listener.id in connector.links(), 'the link')
        return listener, connector

    return open_both
