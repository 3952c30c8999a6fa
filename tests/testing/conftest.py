from __future__ import annotations

from collections.abc import Iterator

import pytest

from goalwire.testing import Graph, VirtualClock


@pytest.fixture
def clock() -> Iterator[VirtualClock]:
    with VirtualClock() as clock:
        yield clock


@pytest.fixture
def graph(clock: VirtualClock) -> Iterator[Graph]:
    """A graph in virtual time: no test here waits for anything."""
    with Graph() as graph:
        yield graph
