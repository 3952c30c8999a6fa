"""roslibpy, unmodified, as a client of `goalwire bridge rosbridge`."""

from __future__ import annotations

import pytest
from helpers.processes import Program

from .conftest import PROGRAMS


def test_its_topics_services_parameters_and_actions_work(rosbridge: str, world: dict[str, str]) -> None:
    pytest.importorskip('roslibpy')
    with Program(PROGRAMS / 'roslibpy_client.py', rosbridge, env=world) as client:
        client.expect('topics True')
        client.expect('parameter 0.5')
        client.expect('sum 3')
        client.expect('heard roslibpy')
        client.expect(r"GoalStatus.SUCCEEDED {'sequence': \[0, 1, 1, 2, 3\]}")
        client.expect('GoalStatus.CANCELED')
        client.succeed()
