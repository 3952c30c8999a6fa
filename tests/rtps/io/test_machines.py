"""Sessions on two machines, which are network namespaces with a cable between them."""

from __future__ import annotations

import json
import os
from collections.abc import Iterator
from pathlib import Path

import pytest
from helpers.cable import cabled_machines, can_make_cables
from helpers.machines import Machine, can_make_machines, two_machines
from helpers.processes import Program

from goalwire.transport.faults import Faults

GREETER = Path(__file__).parent / 'programs' / 'greeter.py'

pytestmark = [
    pytest.mark.slow,
    pytest.mark.skipif(not can_make_machines(), reason='needs root and network namespaces'),
]


@pytest.fixture
def machines() -> Iterator[tuple[Machine, Machine]]:
    """Two machines with a cable."""
    with two_machines('192.0.2.1', '192.0.2.2') as both:
        yield both


def _greet(machine: Machine, name: str, **settings: object) -> Program:
    return machine.run(GREETER, name, json.dumps(settings), env=dict(os.environ))


def test_two_machines_meet_by_multicast(machines: tuple[Machine, Machine]) -> None:
    one, other = machines
    with _greet(one, 'one') as first, _greet(other, 'other') as second:
        first.expect('greeted by other')
        second.expect('greeted by one')


@pytest.mark.skipif(not can_make_cables(), reason='needs TAP devices')
@pytest.mark.parametrize('namer', ['the first', 'the second', 'both'])
def test_without_multicast_it_is_enough_if_one_names_the_other(namer: str) -> None:
    with cabled_machines('192.0.2.1', '192.0.2.2', Faults(), carries_multicast=False) as (one, other):
        names_it, is_named = namer != 'the second', namer != 'the first'
        peers = [other.address] if names_it else [], [one.address] if is_named else []
        with _greet(one, 'one', peers=peers[0]) as first, _greet(other, 'other', peers=peers[1]) as second:
            first.expect('greeted by other')
            second.expect('greeted by one')


@pytest.mark.skipif(not can_make_cables(), reason='needs TAP devices')
def test_without_multicast_and_without_names_nobody_is_met() -> None:
    with (
        cabled_machines('192.0.2.1', '192.0.2.2', Faults(), carries_multicast=False) as (one, other),
        _greet(one, 'one') as first,
        _greet(other, 'other') as second,
        _greet(one, 'third') as third,
    ):
        for each in (first, third):
            each.expect('greeted by third')
        with pytest.raises(AssertionError, match='ran for 1'):
            second.expect('greeted by one', timeout=1)


def test_an_address_that_comes_is_used_and_told(machines: tuple[Machine, Machine]) -> None:
    one, other = machines
    one.remove_address(one.address)
    with _greet(one, 'one') as first, _greet(other, 'other') as second:
        first.expect('greeted by one')
        second.expect('greeted by other')
        one.add_address('192.0.2.1')
        first.expect('greeted by other')
        second.expect('greeted by one')


def test_an_address_that_goes_is_taken_back(machines: tuple[Machine, Machine]) -> None:
    one, other = machines
    one.add_device('second', '198.51.100.1')
    with _greet(one, 'one') as first, _greet(other, 'other') as second:
        second.expect('at 192.0.2.1 198.51.100.1')
        second.expect('greeted by one')
        first.expect('greeted by other')
        one.remove_device('second')
        second.expect('at 192.0.2.1')


def test_a_machine_that_gets_another_address_is_met_again(machines: tuple[Machine, Machine]) -> None:
    one, other = machines
    with _greet(one, 'one', lease_s=2.0, announce_s=0.5) as first, _greet(other, 'other') as second:
        second.expect('greeted by one')
        first.expect('greeted by other')
        one.remove_address(one.address)
        one.add_address('192.0.2.77')
        second.expect('left')
        second.expect('at 192.0.2.77')
        second.expect('greeted by one')


def test_only_interfaces_that_are_chosen_are_told(machines: tuple[Machine, Machine]) -> None:
    one, other = machines
    one.add_device('second', '198.51.100.1')
    with _greet(one, 'one', interfaces=['cable']), _greet(other, 'other') as second:
        second.expect('at 192.0.2.1')
        second.expect('greeted by one')


@pytest.mark.parametrize('multicast', [True, False])
def test_two_machines_meet_on_ipv6(machines: tuple[Machine, Machine], multicast: bool) -> None:
    one, other = machines
    one.add_address('fd00::1', 64)
    other.add_address('fd00::2', 64)
    settings: dict[str, object] = {'ipv6': True, 'multicast': multicast}
    with (
        _greet(one, 'one', peers=[] if multicast else ['fd00::2'], **settings) as first,
        _greet(other, 'other', **settings) as second,
    ):
        first.expect('greeted by other')
        second.expect('greeted by one')
