"""Independent implementations of rmw_zenoh's wire: a topic and a service, both ways, over ours."""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple, TypeAlias

import pytest
from helpers.environments import Environment
from helpers.processes import Program

pytestmark = [pytest.mark.slow, pytest.mark.timeout(400)]

Run: TypeAlias = Callable[..., Program]
Install: TypeAlias = Callable[..., Environment]

WARM_UP = 120.0
"""Seconds: pyzeros compiles its encoder with a C compiler when it is first used."""


class Peer(NamedTuple):
    """One implementation: its program, which is also its node's name, and what has to be installed for it."""

    program: str
    requirements: tuple[str, ...]

    def __str__(self) -> str:
        return self.requirements[0]


SDK = Peer('sdk_peer', ('zenoh-ros2-sdk==0.1.8',))
PYZEROS = Peer('pyzeros_peer', ('pyzeros==0.1.0', 'setuptools'))


@pytest.fixture(params=[SDK, pytest.param(PYZEROS, marks=pytest.mark.long)], ids=str)
def chosen(request: pytest.FixtureRequest) -> Peer:
    """Each implementation in turn."""
    peer: Peer = request.param
    return peer


@pytest.fixture
def peer(chosen: Peer, run: Run, install: Install) -> Callable[[str], Program]:
    """A function that runs the peer in a role: echo, serve or call."""
    environment = install(*chosen.requirements)
    codecs = str(environment.folder / 'codecs')
    return lambda role: run(chosen.program, role, python=environment.python, CYDR_CACHE_DIR=codecs)


@pytest.mark.long
def test_a_topic_goes_both_ways_and_the_peer_is_seen(
    run: Run, chosen: Peer, peer: Callable[[str], Program]
) -> None:
    run('rendezvous').expect('ready')
    peer('echo').expect('ready', WARM_UP)
    peers = run('echo_caller').succeed().splitlines()[-1].split()
    assert chosen.program in peers


def test_a_peer_calls_our_service(run: Run, peer: Callable[[str], Program]) -> None:
    run('switch_server').expect('ready')
    client = peer('call')
    client.expect('True it is on', WARM_UP)
    client.expect('True it is off')
    client.succeed()


def test_we_call_a_peers_service(run: Run, peer: Callable[[str], Program]) -> None:
    run('rendezvous').expect('ready')
    peer('serve').expect('ready', WARM_UP)
    client = run('switch_client')
    client.expect('True it is on')
    client.expect('True it is off')
    client.succeed()
