"""Items 9 and 10: two machines, and what can become of the network between them.

The cable is this process: it delays, loses, reorders and cuts packets of both wires where the kernel need
not have netem. Machines are network namespaces of Linux, which takes root.
"""

from __future__ import annotations

import time
from collections.abc import Iterator
from contextlib import ExitStack
from functools import cache
from typing import NamedTuple

import pytest
from helpers.cable import cabled_machines, can_make_cables
from helpers.machines import Machine, can_make_machines
from helpers.outcomes import Outcomes
from helpers.processes import Program

from goalwire.transport.faults import Delay, Fault, Faults, Loss, Reordering, SlowReader

from .conftest import BETWEEN_PROCESSES, LONG, PROGRAMS, Evidence, impatient_world, told

pytestmark = [pytest.mark.slow, BETWEEN_PROCESSES]

SERVER, CLIENT = '10.77.0.1', '10.77.0.2'


@cache
def cables_work() -> bool:
    return can_make_machines() and can_make_cables()


class Network(NamedTuple):
    """An arm on /a, its client on /b, and the faults of the cable between them."""

    mission: Program
    faults: Faults
    machines: tuple[Machine, Machine]

    def calls(self, seconds: float, number: int, outcomes: Outcomes) -> None:
        """Have the client call so often, and count the ends."""
        self.mission.write_line(f'call ask {seconds} {number}')
        for _ in range(number):
            told(self.mission, outcomes)


@pytest.fixture
def network(transport_name: str) -> Iterator[Network]:
    """Both programs, connected."""
    if not cables_work():
        pytest.skip('network namespaces and TAP devices take Linux and root')
    faults = Faults(seed=7)
    world = impatient_world(transport_name, lease_s=2.0) | {
        'GOALWIRE_ROUTER': 'off',
        'ROS_AUTOMATIC_DISCOVERY_RANGE': 'SUBNET',
    }
    there = {
        'listen': f'connect/endpoints=[];listen/endpoints=["tcp/{SERVER}:7447"]',
        'connect': f'connect/endpoints=["tcp/{SERVER}:7447"]',
    }
    with ExitStack() as stack:
        machines = stack.enter_context(cabled_machines(SERVER, CLIENT, faults))
        programs = []
        for machine, name, how in zip(machines, ('arm', 'mission'), ('listen', 'connect'), strict=True):
            env = world | {'ZENOH_CONFIG_OVERRIDE': f'{there[how]};{world["ZENOH_CONFIG_OVERRIDE"]}'}
            programs.append(stack.enter_context(machine.run(PROGRAMS / f'{name}.py', env=env)))
            programs[-1].expect('ready')
        whole = Network(programs[1], faults, machines)
        whole.calls(20.0, 1, Outcomes())
        yield whole
        faults.heal()


def ping(network: Network, outcomes: Outcomes, *, calls: int = 20) -> None:
    network.calls(20.0, calls, outcomes)
    network.mission.write_line('goal 5 30.0')
    told(network.mission, outcomes)


CONDITIONS: dict[str, list[Fault]] = {
    'delay 20 ms': [Delay(0.02)],
    'delay 300 ms': [Delay(0.3)],
    'delay 20 ms, jitter 20 ms': [Delay(0.02, jitter=0.02)],
    'loss 1 %': [Loss(rate=0.01)],
    'loss 10 %': [Loss(rate=0.1)],
    'reorder 25 %': [Reordering(rate=0.25, by=0.01)],
    '500 kbit/s': [SlowReader(bytes_per_s=500_000 / 8, room=1000)],
}
ALL_AT_ONCE = 'delay 10 ms, jitter 10 ms, loss 3 %, reorder 25 %'


def test_on_a_bad_network_nothing_is_lost(network: Network, evidence: Evidence) -> None:
    outcomes = Outcomes()
    for fault in (Delay(0.01, jitter=0.01), Loss(rate=0.03), Reordering(rate=0.25)):
        network.faults.add(fault)
    ping(network, outcomes, calls=10)
    assert outcomes.counts == {'done': 11}
    evidence(10, ALL_AT_ONCE, outcomes)


@LONG
@pytest.mark.parametrize('condition', CONDITIONS)
def test_in_each_condition_nothing_is_lost(network: Network, evidence: Evidence, condition: str) -> None:
    outcomes = Outcomes()
    for fault in CONDITIONS[condition]:
        network.faults.add(fault)
    ping(network, outcomes)
    assert outcomes.counts == {'done': 21}
    evidence(10, condition, outcomes)


HEALED_S = 10.0
"""Within which two that have lost each other talk again: on DDS they announce themselves every 5 s."""

WAYS = {
    'both': 'both ways',
    'deaf': 'towards the client',
    'mute': 'towards the server',
    'flap': 'as its network device is down',
}


def part(network: Network, way: str) -> None:
    """Cut the cable, or one direction of it: the client hears nothing ('deaf') or is not heard ('mute')."""
    if way == 'flap':
        network.machines[1].switch('down')
    else:
        here, there = ('b', 'a') if way == 'mute' else ('a', 'b')
        network.faults.partition(here, there, one_way=way != 'both')


def join(network: Network, way: str) -> None:
    if way == 'flap':
        network.machines[1].switch('up')
    network.faults.heal()


def survive_partition(network: Network, seconds: float, way: str) -> Outcomes:
    """Call all the time while nothing passes; then insist on an answer once it does again."""
    outcomes = Outcomes()
    began = time.monotonic()
    part(network, way)
    while time.monotonic() - began < seconds:
        network.calls(0.25, 1, outcomes)
    join(network, way)
    assert 'done' not in outcomes.counts
    assert set(outcomes.counts) <= {'DeadlineError', 'ServerLostError', 'NoServerError'}
    healed = time.monotonic()
    while 'done' not in outcomes.counts:  # a call that is sent just then may be lost with the old connection
        assert time.monotonic() - healed < HEALED_S, outcomes.counts
        network.calls(HEALED_S, 1, outcomes)
    return outcomes


@pytest.mark.parametrize('way', ['both', 'mute'])
def test_calls_fail_by_type_while_nothing_passes_and_are_answered_again_after(
    network: Network, evidence: Evidence, way: str
) -> None:
    outcomes = survive_partition(network, 1.0, way)
    evidence(9, f'a cable cut for 1 s, {WAYS[way]}', outcomes)


@LONG
@pytest.mark.parametrize('way', WAYS)
@pytest.mark.parametrize('seconds', [5, 30])
def test_partitions_longer_than_the_lease_heal_as_well(
    network: Network, evidence: Evidence, seconds: int, way: str
) -> None:
    outcomes = survive_partition(network, seconds, way)
    evidence(9, f'a cable cut for {seconds} s, {WAYS[way]}', outcomes)


def test_a_call_under_way_outlives_a_partition_shorter_than_the_lease(
    network: Network, evidence: Evidence
) -> None:
    outcomes = Outcomes()
    network.faults.partition('a', 'b')
    network.mission.write_line('call ask 20.0')
    with pytest.raises(AssertionError, match='without a line'):
        network.mission.expect('^ended', timeout=0.5)
    network.faults.heal()
    assert told(network.mission, outcomes) == 'done'
    evidence(9, 'a cable cut for 0.5 s while a call waits', outcomes)
