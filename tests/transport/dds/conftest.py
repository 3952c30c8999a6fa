"""What a real ROS 2 Jazzy sent over Cyclone DDS."""

from __future__ import annotations

import json
import os
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path

import pytest
from helpers.captured import Captured
from helpers.isolation import isolated_env
from helpers.wire import Side

from goalwire.errors import TransportError
from goalwire.transport.contract import EndpointKind, SessionOptions
from goalwire.transport.dds import TRANSPORT
from goalwire.transport.dds.cyclone.library import find_library

CAPTURED = Path(__file__).parents[2] / 'data' / 'dds' / 'captured.jsonl'


@pytest.fixture(scope='session')
def captured() -> list[Captured]:
    """Every captured message."""
    lines: list[Mapping[str, str]] = [json.loads(line) for line in CAPTURED.read_text().splitlines()]
    return [
        Captured(line['what'], line['topic'], bytes.fromhex(line['hex']), line['meaning']) for line in lines
    ]


@pytest.fixture
def alone(monkeypatch: pytest.MonkeyPatch) -> dict[str, str]:
    """A domain of its own on DDS; returns the environment, for child processes in the same domain."""
    try:
        find_library()
    except TransportError as error:
        pytest.skip(str(error))
    env = isolated_env('rmw_cyclonedds_cpp')
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
