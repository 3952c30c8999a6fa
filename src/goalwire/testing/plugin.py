"""The pytest plugin: `gw_graph`, `gw_clock`, `gw_expect` and --gw-transport.

Pytest imports it in every project that has goalwire installed. So this module imports little, and the
fixtures import the rest when they are used.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import pytest

if TYPE_CHECKING:
    from collections.abc import Iterator

    from goalwire.testing import Expect, Graph, VirtualClock


def pytest_addoption(parser: pytest.Parser) -> None:
    """Offer --gw-transport."""
    group = parser.getgroup('goalwire')
    group.addoption(
        '--gw-transport',
        choices=('memory', 'zenoh', 'dds'),
        default='memory',
        help='what gw_graph is made of: memory (default), zenoh or dds',
    )


@pytest.fixture
def gw_clock(request: pytest.FixtureRequest) -> Iterator[VirtualClock]:
    """Virtual time: hours take milliseconds, and events come in the same order in each run. Only for the
    memory wire.
    """
    transport = request.config.getoption('--gw-transport')
    if transport != 'memory':
        pytest.skip(f'virtual time needs the transport memory, and this run is on {transport}')
    from goalwire.testing import VirtualClock

    with VirtualClock() as clock:
        yield clock


@pytest.fixture
def gw_graph(request: pytest.FixtureRequest) -> Iterator[Graph]:
    """A graph for this test only, with nodes, scripted servers and recorders; see goalwire.testing.Graph."""
    if 'gw_clock' in request.fixturenames:
        request.getfixturevalue('gw_clock')  # virtual time must begin before the graph is made
    from goalwire.testing import Graph

    with Graph(request.config.getoption('--gw-transport')) as graph:
        yield graph


@pytest.fixture
def gw_expect(gw_graph: Graph) -> Expect:
    """`gw_expect('bag')`: the servers in `gw_graph` must answer a bag's calls and goals as recorded."""
    from goalwire.testing import Expect

    return Expect(gw_graph)
