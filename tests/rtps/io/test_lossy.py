"""Real sockets over a cable that loses, doubles, delays and reorders packets."""

from __future__ import annotations

import os
import time
from collections.abc import Iterator
from contextlib import ExitStack
from pathlib import Path

import pytest
from helpers.cable import cabled_machines, can_make_cables
from helpers.machines import Machine, can_make_machines
from helpers.processes import Program

from goalwire.transport.faults import Delay, Duplication, Faults, Loss, Reordering

PROGRAMS = Path(__file__).parent / 'programs'
ONE, OTHER = '192.0.2.1', '192.0.2.2'

pytestmark = [
    pytest.mark.slow,
    pytest.mark.skipif(not (can_make_machines() and can_make_cables()), reason='needs root and TAP devices'),
]


@pytest.fixture
def faults() -> Faults:
    """The cable's, none of them at first."""
    return Faults(seed=5)


@pytest.fixture
def machines(faults: Faults) -> Iterator[tuple[Machine, Machine]]:
    with cabled_machines(ONE, OTHER, faults) as both:
        yield both


def _run(stack: ExitStack, machine: Machine, role: str, number: int, reliability: str) -> Program:
    peer = OTHER if machine.address == ONE else ONE
    arguments = role, str(number), peer, reliability
    return stack.enter_context(machine.run(PROGRAMS / 'stream.py', *arguments, env=dict(os.environ)))


@pytest.mark.parametrize(
    ('share', 'number'),
    [(0.1, 1000), pytest.param(0.3, 20_000, marks=[pytest.mark.long, pytest.mark.timeout(600)])],
)
def test_reliable_means_none_lost_doubled_or_out_of_order(
    machines: tuple[Machine, Machine], faults: Faults, share: float, number: int
) -> None:
    with ExitStack() as stack:
        reader = _run(stack, machines[0], 'read', number, 'reliable')
        writer = _run(stack, machines[1], 'write', number, 'reliable')
        writer.expect('met')
        for fault in (Loss(rate=share), Duplication(rate=share), Reordering(rate=share, by=0.005)):
            faults.add(fault)
        faults.add(Delay(0.001))
        patience = 20 if number < 5000 else 500
        reader.expect(f'{number} came, 0 wrong', patience)
        writer.expect('acknowledged True', patience)


def test_best_effort_blocks_nobody_and_stays_in_order(
    machines: tuple[Machine, Machine], faults: Faults
) -> None:
    with ExitStack() as stack:
        reader = _run(stack, machines[0], 'read', 500, 'best-effort')
        writer = _run(stack, machines[1], 'write', 500, 'best-effort')
        writer.expect('met')
        loss = faults.add(Loss(rate=0.3))
        faults.add(Reordering(rate=0.3, by=0.005))
        assert float(writer.expect(r'longest ([\d.]+)')[1]) < 1.0
        faults.heal(loss)
        assert int(reader.expect(r'(\d+) came, 0 wrong')[1]) > 100


@pytest.mark.long
@pytest.mark.timeout(600)
def test_a_partition_of_a_minute_heals(machines: tuple[Machine, Machine], faults: Faults) -> None:
    with ExitStack() as stack:
        greeters = [
            stack.enter_context(
                machine.run(PROGRAMS / 'greeter.py', name, '{"lease_s": 5}', env=dict(os.environ))
            )
            for machine, name in zip(machines, ('one', 'other'), strict=True)
        ]
        greeters[0].expect('greeted by other')
        greeters[1].expect('greeted by one')
        cut = faults.add(Loss())
        time.sleep(60)  # that is the scenario
        faults.heal(cut)
        greeters[0].expect('left')
        greeters[0].expect('greeted by other')
        greeters[1].expect('greeted by one')
