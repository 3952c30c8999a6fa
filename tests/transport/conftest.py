"""Two sides that see each other, for the contract suite."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TypeAlias

import pytest
from helpers.wire import Side
from helpers.wires import DDS, TRANSPORTS, opens_native, require, require_wire, skip_differing

from goalwire.transport import dds
from goalwire.transport.contract import EndpointKind, Session
from goalwire.transport.faults import Faults
from goalwire.transport.zenoh.settings.environment import CHOICE, ECLIPSE, NATIVE

Sides: TypeAlias = tuple[Side, Side]


UNDER_FAULTS = 'goalwire_memory under no fault'
OTHER_SESSIONS = 'rmw_zenoh_cpp with the sessions that are not chosen'
OTHER_DDS = f'{DDS} with the sessions that are not chosen'


@pytest.fixture(params=[*sorted({*TRANSPORTS, DDS}), OTHER_SESSIONS, OTHER_DDS, UNDER_FAULTS])
def transport_name(request: pytest.FixtureRequest, monkeypatch: pytest.MonkeyPatch) -> Iterator[str]:
    """Each transport in turn, DDS always among them: the contract is what they have in common.

    One comes in the wrapping that faults are made in, too; Zenoh and DDS with sessions of either make.
    """
    if request.param == UNDER_FAULTS:
        with Faults():
            yield 'goalwire_memory'
    elif request.param == OTHER_SESSIONS:
        monkeypatch.setenv(CHOICE, ECLIPSE if opens_native() else NATIVE)
        yield 'rmw_zenoh_cpp'
    elif request.param == OTHER_DDS:
        others = dds.CYCLONE if dds.choose_session() == dds.NATIVE else dds.NATIVE
        monkeypatch.setenv(dds.CHOICE, others)
        skip_differing(request, DDS)
        require(DDS)
        yield DDS
    else:
        yield require_wire(request)


@pytest.fixture
def sides(session_pair: tuple[Session, Session]) -> Sides:
    """Two sessions with the nodes /alpha and /beta, each knowing of the other."""
    alpha, beta = Side(session_pair[0], 'alpha'), Side(session_pair[1], 'beta')
    alpha.graph.expect(EndpointKind.NODE, '/beta')
    beta.graph.expect(EndpointKind.NODE, '/alpha')
    return alpha, beta
