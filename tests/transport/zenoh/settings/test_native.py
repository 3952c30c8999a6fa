"""Which configurations a session of ours is opened with, and which it leaves to eclipse-zenoh."""

from __future__ import annotations

from copy import deepcopy
from pathlib import Path

import pytest

from goalwire.transport.zenoh.settings import built_in, environment, json5
from goalwire.transport.zenoh.settings.native import BeyondOursError, native_settings
from goalwire.transport.zenoh.settings.values import Configuration, Json, Settings
from goalwire.zenoh.io.dialler import Retry
from goalwire.zenoh.io.settings import MemorySettings
from goalwire.zenoh.protocol.link_messages import Role

DATA = Path(__file__).parents[3] / 'data' / 'zenoh'
PLAIN: Settings = {
    'scouting': {'multicast': {'enabled': False}, 'gossip': {'target': ['router']}},
    'transport': {'shared_memory': {'enabled': False}},
    'timestamping': {'enabled': True},
}


def with_(path: str, value: Json) -> Configuration:
    """Return plain settings with one more."""
    changed = Configuration(deepcopy(PLAIN))
    changed.set(path, value)
    return changed


def test_rmws_own_file_opens_a_session_of_ours() -> None:
    values = json5.read((DATA / 'session.json5').read_text(encoding='utf-8')).value
    opened = native_settings(values)
    assert opened.role is Role.PEER
    assert opened.connect == ('tcp/localhost:7447',)
    assert opened.listen == ('tcp/localhost:0',)
    assert opened.lease_ms == 60_000
    assert opened.untimed_s == 600.0
    assert opened.retry == Retry(1.0, 4.0, 2.0)
    assert (opened.meets_peers, opened.must_connect) == (True, False)


def test_the_built_in_settings_open_a_session_of_ours() -> None:
    assert native_settings(built_in.session(7500)).connect == ('tcp/localhost:7500',)


def test_who_reaches_nobody_is_told_what_to_do() -> None:
    peer, client = (native_settings({**PLAIN, 'mode': mode}) for mode in ('peer', 'client'))
    assert peer.advice.startswith('check ZENOH_SESSION_CONFIG_URI, ZENOH_CONFIG_OVERRIDE and')
    assert client.advice == f'{environment.START_ROUTER}, or {peer.advice}'


def test_what_is_not_set_is_as_zenohs_defaults_have_it() -> None:
    opened = native_settings(PLAIN)
    assert (opened.role, opened.listen, opened.connect) == (Role.PEER, ('tcp/[::]:0',), ())
    assert (opened.lease_ms, opened.untimed_s, opened.must_connect) == (10_000, 10.0, None)
    assert native_settings(with_('mode', 'client').values).listen == ()


def test_memory_is_shared_with_all_as_the_configuration_says_and_with_our_own_from_what_pays() -> None:
    sizes: Json = {'pool_size': 1 << 20, 'message_size_threshold': 512}
    values = with_('transport/shared_memory', {'enabled': True, 'transport_optimization': sizes}).values
    assert native_settings(values).memory == MemorySettings(True, True, 1 << 20, 512)
    values['transport']['shared_memory']['enabled'] = False  # type: ignore[index, call-overload]
    assert native_settings(values, shares_with_own=True).memory == MemorySettings(True, False, 1 << 20, 65536)
    assert not native_settings(values).memory.with_own


def test_what_differs_by_mode_is_taken_for_this_one() -> None:
    values = with_('connect/endpoints', {'peer': ['tcp/[::1]:1'], 'client': ['tcp/[::1]:2']})
    values.set('connect/retry', {'period_init_ms': {'peer': 50, 'client': 70}})
    values.set('connect/exit_on_failure', {'peer': True})
    values.set('connect/timeout_ms', {'peer': 1500, 'client': -1})
    opened = native_settings(values.values)
    assert (opened.connect, opened.retry.first_s) == (('tcp/[::1]:1',), 0.05)
    assert (opened.must_connect, opened.connecting_s) == (True, 1.5)
    values.set('mode', 'client')
    opened = native_settings(values.values)
    assert (opened.connect, opened.retry.first_s) == (('tcp/[::1]:2',), 0.07)
    assert (opened.must_connect, opened.connecting_s) == (None, float('inf'))


@pytest.mark.parametrize(
    ('path', 'value'),
    [
        ('mode', 'router'),
        ('listen/endpoints', ['udp/127.0.0.1:1']),
        ('listen/endpoints', ['quic/127.0.0.1:1']),
        ('connect/endpoints', ['serial//dev/ttyUSB0#baudrate=115200']),
        ('connect/endpoints', ['tcp/127.0.0.1:1#iface=eth0']),
        ('connect/endpoints', ['tcp/127.0.0.1:1?prio=1-3']),
        ('connect/endpoints', [{'strategy': 'oneOf', 'locators': ['tcp/127.0.0.1:1']}]),
        ('scouting/multicast/enabled', True),
        ('scouting/multicast', {}),
        ('scouting/gossip/target', ['router', 'peer']),
        ('scouting/gossip', {}),
        ('scouting/gossip/multihop', True),
        ('transport/shared_memory/transport_optimization/messages', ['put']),
        ('transport/unicast/compression/enabled', True),
        ('transport/unicast/lowlatency', True),
        ('transport/unicast/qos/enabled', False),
        ('transport/unicast/max_links', 4),
        ('transport/link/tx/sequence_number_resolution', '16bit'),
        ('transport/auth/usrpwd/user', 'me'),
        ('access_control', {'enabled': True}),
        ('downsampling', [{'id': 'x'}]),
        ('namespace', 'robot1'),
        ('plugins', {'rest': {'http_port': 8000}}),
        ('listen/exit_on_failure', False),
        ('not_known/yet', 1),
    ],
)
def test_what_ours_does_not_do_is_named(path: str, value: Json) -> None:
    with pytest.raises(BeyondOursError) as caught:
        native_settings(with_(path, value).values)
    named = str(caught.value)
    assert any(part in named for part in (path, path.rsplit('/', 1)[-1], str(value)[2:6]))
