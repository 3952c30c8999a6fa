"""Sessions on libddsc, whatever is the default."""

from __future__ import annotations

import os
from collections.abc import Iterator
from contextlib import contextmanager

import pytest
from helpers.isolation import isolated_env
from helpers.wire import Side

from goalwire.errors import TransportError
from goalwire.transport.contract import EndpointKind, SessionOptions
from goalwire.transport.dds import CHOICE, CYCLONE, TRANSPORT
from goalwire.transport.dds.cyclone.library import find_library


@pytest.fixture
def alone(monkeypatch: pytest.MonkeyPatch) -> dict[str, str]:
    """A domain of its own on libddsc; returns the environment, for child processes in the same domain."""
    try:
        find_library()
    except TransportError as error:
        pytest.skip(str(error))
    env = isolated_env('rmw_cyclonedds_cpp') | {CHOICE: CYCLONE}
    for name in set(os.environ) - set(env):
        monkeypatch.delenv(name)
    for name, value in env.items():
        monkeypatch.setenv(name, value)
    return env


@contextmanager
def two_sides(domain_of_alpha: int, domain_of_beta: int) -> Iterator[tuple[Side, Side]]:
    """Two sessions with the nodes /alpha and /beta, each knowing of the other."""
    alpha = TRANSPORT.open(SessionOptions(domain_of_alpha))
    beta = TRANSPORT.open(SessionOptions(domain_of_beta))
    try:
        sides = Side(alpha, 'alpha'), Side(beta, 'beta')
        sides[0].graph.expect(EndpointKind.NODE, '/beta')
        sides[1].graph.expect(EndpointKind.NODE, '/alpha')
        yield sides
    finally:
        alpha.close()
        beta.close()


@pytest.fixture
def dds_sides(alone: dict[str, str]) -> Iterator[tuple[Side, Side]]:
    """Two sessions in one domain."""
    domain = int(alone['ROS_DOMAIN_ID'])
    with two_sides(domain, domain) as sides:
        yield sides


@pytest.fixture
def sides_apart(alone: dict[str, str], monkeypatch: pytest.MonkeyPatch) -> Iterator[tuple[Side, Side]]:
    """Two sessions in domains that share only the network."""
    domain = int(alone['ROS_DOMAIN_ID'])
    shared = f'<Discovery><ExternalDomainId>{domain}</ExternalDomainId></Discovery>'
    monkeypatch.setenv('CYCLONEDDS_URI', f'<CycloneDDS><Domain>{shared}</Domain></CycloneDDS>')
    with two_sides(domain, domain + 1) as sides:
        yield sides
