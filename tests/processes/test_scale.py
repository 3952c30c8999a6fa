"""Many clients, many goals: none is lost, and each gets its own answer."""

from __future__ import annotations

import pytest
from helpers.programs import Start

pytestmark = pytest.mark.slow

CLIENT_PROCESSES = 4


def test_a_hundred_clients_get_all_of_ten_thousand_answers(start: Start) -> None:
    """4 processes of 25 clients, each with 100 calls, 32 of them in flight: 3200 at once."""
    start('add_server').expect('ready')
    clients = [start('add_clients', number, 25, 100, 32) for number in range(CLIENT_PROCESSES)]
    for client in clients:
        client.expect('ready')
    for client in clients:
        client.write_line('go')
    for client in clients:
        assert '2500 right answers' in client.succeed(timeout=60.0)


def test_a_thousand_concurrent_goals_each_end_with_their_own_result(start: Start) -> None:
    """2 processes with 500 goals each; no goal ends before all 1000 are being executed."""
    server = start('gathering_server', 1000)
    server.expect('ready')
    clients = [start('gathering_client', first, 500) for first in (0, 500)]
    for client in clients:
        assert '500 right results' in client.succeed(timeout=60.0)
