"""A server that ends right after its reply: the reply arrives, also if its client is slow to read it."""

from __future__ import annotations

import sys

import pytest
from helpers.isolation import NETWORK
from helpers.programs import Start
from helpers.wires import DDS

pytestmark = pytest.mark.skipif(sys.platform == 'win32', reason='signals of POSIX')


@pytest.mark.parametrize('network', [NETWORK, DDS], indirect=True)
def test_a_reply_arrives_although_its_server_has_ended(start: Start, network: str) -> None:
    server = start('farewell', 'server')
    server.expect('ready')
    client = start('farewell', 'client')
    client.expect('answer 42')
    client.succeed()
    server.succeed()
