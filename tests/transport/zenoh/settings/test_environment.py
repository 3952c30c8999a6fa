"""The settings of a session that come from the environment."""

from __future__ import annotations

from pathlib import Path

import pytest

from goalwire.errors import TransportError
from goalwire.transport.zenoh.settings.environment import (
    Override,
    RendezvousChoice,
    overrides,
    rendezvous_choice,
    router_check_seconds,
    router_port,
    shared_memory,
    shares_memory,
)


def test_the_rendezvous_is_at_7447_unless_told_otherwise() -> None:
    assert router_port({}) == 7447
    assert router_port({'GOALWIRE_ROUTER_PORT': ''}) == 7447
    assert router_port({'GOALWIRE_ROUTER_PORT': '7500'}) == 7500


@pytest.mark.parametrize('text', ['x', '0', '-1', '65536', '74.5', '²'])
def test_a_port_that_is_none_is_refused(text: str) -> None:
    with pytest.raises(TransportError, match='GOALWIRE_ROUTER_PORT'):
        router_port({'GOALWIRE_ROUTER_PORT': text})


@pytest.mark.parametrize(
    ('env', 'choice'),
    [
        ({}, RendezvousChoice.AUTO),
        ({'GOALWIRE_ROUTER': 'on'}, RendezvousChoice.ON),
        ({'GOALWIRE_ROUTER': 'off'}, RendezvousChoice.OFF),
        ({'AMENT_PREFIX_PATH': '/a/workspace:{ros}'}, RendezvousChoice.OFF),
        ({'AMENT_PREFIX_PATH': '{ros}', 'GOALWIRE_ROUTER': 'on'}, RendezvousChoice.ON),
        ({'AMENT_PREFIX_PATH': '/a/workspace'}, RendezvousChoice.AUTO),
        ({'AMENT_PREFIX_PATH': ''}, RendezvousChoice.AUTO),
    ],
)
def test_a_machine_with_rmw_zenoh_keeps_its_router_port(
    env: dict[str, str], choice: RendezvousChoice, tmp_path: Path
) -> None:
    """A workspace of goalwire's users alone has no rmw_zenohd: its programs meet by themselves."""
    marker = tmp_path / 'share/ament_index/resource_index/packages/rmw_zenoh_cpp'
    marker.parent.mkdir(parents=True)
    marker.touch()
    env = {name: text.replace('{ros}', str(tmp_path)) for name, text in env.items()}
    assert rendezvous_choice(env) is choice


def test_an_unknown_choice_names_the_three() -> None:
    with pytest.raises(TransportError, match='auto, on or off'):
        rendezvous_choice({'GOALWIRE_ROUTER': 'maybe'})


def test_overrides_are_split_at_semicolons_and_the_first_equals_sign() -> None:
    text = ' mode="client" ; connect/endpoints=["tcp/10.0.0.5:7447#iface=eth0"];'
    assert overrides({'ZENOH_CONFIG_OVERRIDE': text}) == (
        [
            Override('mode', '"client"'),
            Override('connect/endpoints', '["tcp/10.0.0.5:7447#iface=eth0"]'),
        ],
        [],
    )


def test_parts_that_are_no_pairs_are_told_apart() -> None:
    pairs, broken = overrides({'ZENOH_CONFIG_OVERRIDE': 'nonsense;=1;a=;mode="peer"'})
    assert pairs == [Override('mode', '"peer"')]
    assert broken == ['nonsense', '=1', 'a=']


def test_shared_memory_sizes_have_zenohs_names() -> None:
    env = {'ZENOH_SHM_ALLOC_SIZE': '1048576', 'ZENOH_SHM_MESSAGE_SIZE_THRESHOLD': '2048'}
    assert shared_memory(env) == {'pool_size': 1_048_576, 'message_size_threshold': 2048}
    assert shared_memory({}) == {}


@pytest.mark.parametrize(
    ('name', 'text'),
    [
        ('ZENOH_SHM_ALLOC_SIZE', 'x'),
        ('ZENOH_SHM_ALLOC_SIZE', '0'),
        ('ZENOH_SHM_MESSAGE_SIZE_THRESHOLD', '1000'),
    ],
)
def test_a_bad_size_is_refused_by_name(name: str, text: str) -> None:
    with pytest.raises(TransportError, match=name):
        shared_memory({name: text})


def test_whether_goalwires_programs_share_memory_is_on_or_off() -> None:
    assert shares_memory({'GOALWIRE_SHARED_MEMORY': 'on'})
    assert not shares_memory({'GOALWIRE_SHARED_MEMORY': 'off'})
    with pytest.raises(TransportError, match=r"GOALWIRE_SHARED_MEMORY is 'yes'; set it to on or off"):
        shares_memory({'GOALWIRE_SHARED_MEMORY': 'yes'})


@pytest.mark.parametrize(
    ('text', 'seconds'), [('', 0.0), ('1', 0.0), ('4', 3.0), ('0', float('inf')), ('-1', None)]
)
def test_router_checks_are_a_second_apart(text: str, seconds: float | None) -> None:
    assert router_check_seconds({'ZENOH_ROUTER_CHECK_ATTEMPTS': text}) == seconds


def test_a_router_check_that_is_no_number_is_refused() -> None:
    with pytest.raises(TransportError, match='ZENOH_ROUTER_CHECK_ATTEMPTS'):
        router_check_seconds({'ZENOH_ROUTER_CHECK_ATTEMPTS': 'often'})
