"""A world on Zenoh for one test, and a plain zenoh peer in it."""

from __future__ import annotations

import json
import os
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import TypeAlias

import pytest
import zenoh
from helpers.isolation import isolated_env
from helpers.wire import BARE, Side

from goalwire.transport.contract import SessionOptions
from goalwire.transport.zenoh import TRANSPORT, threads
from goalwire.transport.zenoh.settings.environment import CHOICE, ECLIPSE, NATIVE

OpenSide: TypeAlias = Callable[[str], Side]

on_both = pytest.mark.parametrize('world', [NATIVE, ECLIPSE], indirect=True)
"""Mark of tests that run with sessions of either make, which keeps those right that are chosen least."""
on_eclipse = pytest.mark.parametrize('world', [ECLIPSE], indirect=True)
"""Mark of tests that are about eclipse-zenoh's sessions alone."""


@pytest.fixture
def world(request: pytest.FixtureRequest, monkeypatch: pytest.MonkeyPatch) -> dict[str, str]:
    """The environment of this process and, for whoever wants it, of others: one domain, one port.

    Modules choose whose sessions are opened by `indirect` parameters, as `on_both`.
    """
    env = isolated_env('rmw_zenoh_cpp')
    if hasattr(request, 'param'):
        env[CHOICE] = request.param
    for name in set(os.environ) - set(env):
        monkeypatch.delenv(name)
    for name, value in env.items():
        monkeypatch.setenv(name, value)
    return env


@pytest.fixture
def open_side(world: dict[str, str]) -> Iterator[OpenSide]:
    """A function that opens a session with one node; all are closed after the test."""
    sides: list[Side] = []

    def open_one(node_name: str) -> Side:
        session = TRANSPORT.open(SessionOptions(int(world['ROS_DOMAIN_ID'])))
        sides.append(Side(session, node_name, BARE))
        return sides[-1]

    yield open_one
    for side in sides:
        side.session.close()


@pytest.fixture
def goalwire_side(open_side: OpenSide) -> Side:
    """goalwire's side, the node /ours."""
    return open_side('ours')


@contextmanager
def open_peer(world: dict[str, str]) -> Iterator[zenoh.Session]:
    """Open a zenoh session that knows nothing of goalwire, set up as rmw_zenoh's are."""
    settings = {
        'mode': 'peer',
        'connect': {'endpoints': [f'tcp/localhost:{world["GOALWIRE_ROUTER_PORT"]}']},
        'listen': {'endpoints': ['tcp/localhost:0']},
        'timestamping': {'enabled': True},
        'scouting': {
            'multicast': {'enabled': False},
            'gossip': {'target': {'router': ['router', 'peer'], 'peer': ['router']}},
        },
        'transport': {'shared_memory': {'enabled': False}},
    }
    session = threads.open_session(zenoh.Config.from_json5(json.dumps(settings)))
    try:
        yield session
    finally:
        session.close()  # type: ignore[no-untyped-call]


@pytest.fixture
def peer(world: dict[str, str], goalwire_side: Side) -> Iterator[zenoh.Session]:
    """A plain peer beside goalwire's side."""
    with open_peer(world) as session:
        yield session
