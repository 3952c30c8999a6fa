"""A service and an action between two processes, whichever of them starts first."""

from __future__ import annotations

import pytest
from helpers.processes import Program
from helpers.programs import Start

SERVER_FIRST = [True, False]


def run(start: Start, server: str, client: str, *, server_first: bool) -> Program:
    """Start both; the second only once the first is up (a client: waiting for its server)."""
    if server_first:
        start(server).expect('ready')
        return start(client)
    waiting = start(client)
    waiting.expect('waiting')
    start(server)
    return waiting


@pytest.mark.parametrize('server_first', SERVER_FIRST)
def test_a_service_answers_in_either_start_order(start: Start, server_first: bool) -> None:
    client = run(start, 'add_server', 'add_client', server_first=server_first)
    assert '2 + 3 = 5' in client.succeed()


@pytest.mark.parametrize('server_first', SERVER_FIRST)
def test_goals_end_are_cancelled_and_are_refused_in_either_start_order(
    start: Start, server_first: bool
) -> None:
    client = run(start, 'fibonacci_server', 'fibonacci_client', server_first=server_first)
    output = client.succeed()
    assert 'succeeded [0, 1, 1, 2, 3, 5, 8] after 5 feedback messages' in output
    assert 'canceled with return code 0, 1 goal canceling, [0, 1, 1, 2, 3]' in output
    assert 'refused' in output


@pytest.mark.parametrize('attempt', range(10))
@pytest.mark.slow
def test_two_processes_started_at_the_same_moment_find_each_other(start: Start, attempt: int) -> None:
    server, client = start('add_server'), start('add_client')
    assert '2 + 3 = 5' in client.succeed()
    server.expect('ready')
