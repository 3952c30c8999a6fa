"""Item 20: strangers that take what they can from a node leave it, and its other clients, what they need.

One round of each attack is run here. `python tests/reliability/attacks.py` goes on longer, and prints what
each costs.
"""

from __future__ import annotations

from collections.abc import Iterator

import pytest
from helpers.patience import wait_for

from .attacks import ATTACKS, World, attacked_world

MEMORY_MIB = {'unfinished messages in 16 channels, 200 MB': 400.0}
"""The memory that the target may gain during an attack, if it is not USUAL_MIB."""
USUAL_MIB = 150.0
LEFT_MIB = 120.0
"""How much of it may be left afterwards, for the allocator does not give all back."""
DESCRIPTORS = 200
THREADS = 8
LINES = 12
TOLD = {
    'keys of 3 MB, of wildcards': 'a key was ignored',
    'keys with as many wildcards as are allowed': 'has 256 with wildcards',
    "messages in the other client's name": 'a forged message was ignored',
}
"""The text that the target has logged by the end of an attack. It shows that the attack did its work."""
P99_MS = 3000.0
"""On a machine with a load of ten; else it is below half a second."""


@pytest.fixture(scope='module')
def world() -> Iterator[World]:
    """One target and one client, for all attacks."""
    with attacked_world() as world:
        yield world


@pytest.mark.parametrize('name', ATTACKS)
def test_a_stranger_takes_little_and_the_others_are_served(name: str, world: World) -> None:
    found = world.attack(ATTACKS[name], 0.0)
    assert found.most.memory - found.before.memory < MEMORY_MIB.get(name, USUAL_MIB)
    assert found.after.memory - found.before.memory < LEFT_MIB
    assert found.most.descriptors - found.before.descriptors < DESCRIPTORS
    assert found.most.threads - found.before.threads < THREADS
    assert found.lines <= LINES
    wait_for(lambda: TOLD.get(name, '') in world.target.output, 'the line of the log')
    assert found.calls
    assert not found.wrong
    assert not found.missed
    assert found.p99_ms < P99_MS
