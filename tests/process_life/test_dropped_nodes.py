"""A node that a program drops without `destroy_node()` leaves the graph, as under rclpy."""

from __future__ import annotations

from pathlib import Path

import pytest
from helpers.isolation import isolated_env
from helpers.processes import Program
from helpers.wires import DDS, require

PROGRAM = Path(__file__).parent / 'programs' / 'dropped_nodes.py'


@pytest.mark.parametrize('transport', ['goalwire_memory', 'rmw_zenoh_cpp', DDS])
def test_dropped_nodes_leave_the_graph(transport: str) -> None:
    require(transport)
    with Program(PROGRAM, env=isolated_env(transport)) as program:
        lines = program.succeed().splitlines()
    assert lines[:2] == ['all have left', 'an executor keeps its nodes']
    assert lines[2].endswith('heard, and once')
    assert all('never spun' in line for line in lines[3:])
