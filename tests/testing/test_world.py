"""The environment that keeps a graph to itself."""

from __future__ import annotations

import os

import pytest

from goalwire.errors import LocalError
from goalwire.testing import Graph
from goalwire.testing.world import World


def test_the_environment_is_that_of_the_graph_and_then_again_as_before(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setenv('ROS_DOMAIN_ID', '7')
    monkeypatch.setenv('ZENOH_CONFIG_OVERRIDE', 'mode="client"')
    before = dict(os.environ)
    with Graph('zenoh') as graph:
        assert os.environ['ROS_DOMAIN_ID'] == str(graph.domain) != '7'
        assert 'ZENOH_CONFIG_OVERRIDE' not in os.environ
        assert graph.environment.items() <= os.environ.items()
        assert graph.environment['RMW_IMPLEMENTATION'] == 'rmw_zenoh_cpp'
    assert dict(os.environ) == before


def test_an_unknown_transport_is_refused() -> None:
    with pytest.raises(LocalError, match="'pigeon'; choose memory, zenoh, dds"), Graph('pigeon'):
        pass


def test_worlds_that_are_open_at_once_have_domains_and_ports_of_their_own() -> None:
    with World('zenoh') as one, World('dds') as other:
        assert one.domain != other.domain
        assert 0 < min(one.domain, other.domain) <= max(one.domain, other.domain) <= 230
        assert one.variables['GOALWIRE_ROUTER_PORT'] != other.variables['GOALWIRE_ROUTER_PORT']
    with World('zenoh') as again:
        assert again.domain == one.domain
