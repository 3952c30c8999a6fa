"""What a process holds stays the same however many nodes have come and gone."""

from __future__ import annotations

import sys

import pytest
from helpers.processes import Program
from helpers.programs import Start

pytestmark = [
    pytest.mark.slow,
    pytest.mark.skipif(sys.platform != 'linux', reason='counts in /proc'),
    pytest.mark.timeout(150),
]

MEMORY_KIB = 3000
"""What 1000 nodes with their entities may add: allocators keep a little, 3 KiB a node would be seen."""


def held(churn: Program, when: str) -> tuple[int, int, int]:
    """Return the descriptors, the threads and the memory in KiB that the program reports."""
    descriptors, threads, memory = churn.expect(rf'{when} (\d+) (\d+) (\d+)', timeout=120.0).groups()
    return int(descriptors), int(threads), int(memory)


@pytest.mark.parametrize('transport', ['goalwire_memory', 'rmw_zenoh_cpp'])
def test_nothing_is_left_of_a_thousand_nodes_with_entities(start: Start, transport: str) -> None:
    """Memory is looked at without zenoh, which keeps some KiB of every key ever declared (its issue 1518)."""
    churn = start('churn', 200, 1000, RMW_IMPLEMENTATION=transport)
    before, after = held(churn, 'before'), held(churn, 'after')
    assert after[0] <= before[0], 'descriptors'
    assert after[1] <= before[1], 'threads'
    if transport == 'goalwire_memory':
        assert after[2] - before[2] < MEMORY_KIB
    churn.expect(r"left \['last'\]")
    churn.succeed()
