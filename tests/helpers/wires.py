"""Which wires a scenario for all of them runs on."""

from __future__ import annotations

import os

import pytest

from goalwire.errors import TransportError
from goalwire.transport.dds import CYCLONE, choose_session
from goalwire.transport.dds.cyclone.library import find_library
from goalwire.transport.zenoh.settings.environment import NATIVE, zenoh_choice

DDS = 'rmw_cyclonedds_cpp'
TRANSPORTS = os.environ.get('GOALWIRE_TEST_TRANSPORTS', 'goalwire_memory,rmw_zenoh_cpp').split(',')
"""The wires of most scenarios.

On DDS too run the contract of all wires (tests/transport) and the modules marked `also_on_dds`, which between
them use all that a wire does. All scenarios: GOALWIRE_TEST_TRANSPORTS=rmw_cyclonedds_cpp; all programs:
GOALWIRE_TEST_NETWORK=rmw_cyclonedds_cpp.
"""


def opens_native() -> bool:
    """Whether the Zenoh sessions of this run are goalwire's own."""
    return zenoh_choice() == NATIVE


def require_wire(request: pytest.FixtureRequest) -> str:
    """Return the fixture's wire; skip what is marked as different there, and a wire that is not installed."""
    name: str = request.param
    skip_differing(request, name)
    require(name)
    return name


def skip_differing(request: pytest.FixtureRequest, name: str) -> None:
    """Skip the test if it is marked as different on a wire."""
    for mark in request.node.iter_markers('differs_on'):
        if mark.args[0] == name:
            pytest.skip(mark.args[1])


def require(name: str) -> None:
    """Skip the test if a wire is not installed."""
    if name == DDS and choose_session() == CYCLONE:
        try:
            find_library()
        except TransportError as error:
            pytest.skip(str(error))
