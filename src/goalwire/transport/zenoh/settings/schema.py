"""The settings of Zenoh's configuration, and the values that each takes.

Unknown names are left to eclipse-zenoh, which may be newer. Source: eclipse-zenoh 1.10.2's
DEFAULT_CONFIG.json5; a test compares this table with the installed version.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator
from typing import NamedTuple, TypeAlias

from goalwire.transport.zenoh.settings.values import Json

MODES = ('router', 'peer', 'client')


class Kind(NamedTuple):
    """The values that a setting takes."""

    expected: str
    """The description in words: 'true or false'."""
    fits: Callable[[Json], bool]
    by_mode: bool = False
    """True if the setting may have one value for each mode."""


class Fault(NamedTuple):
    """A value that does not fit."""

    path: str
    expected: str


Schema: TypeAlias = 'dict[str, Schema | Kind]'


def _is_endpoint(value: Json) -> bool:
    """Return whether a value is an address, or a group of addresses."""
    if isinstance(value, dict):
        locators = value.get('locators')
        return isinstance(locators, list) and all(map(_is_endpoint, locators))
    return isinstance(value, str) and re.match(r'[^/]+/.', value) is not None


def _is_number(value: Json) -> bool:
    """Return whether a value is a number that fits into 64 bits. JSON5 has Infinity and NaN, too."""
    return isinstance(value, int | float) and not isinstance(value, bool) and abs(value) < _END


_END = 1 << 64


_ANY = Kind('anything', lambda _: True)
_BOOL = Kind('true or false', lambda value: isinstance(value, bool))
_COUNT = Kind('a number', lambda value: _is_number(value) and value >= 0)  # type: ignore[operator]
_NUMBER = Kind('a number', _is_number)
_TEXT = Kind('a text', lambda value: isinstance(value, str))
_LIST = Kind('a list', lambda value: isinstance(value, list))
_MODE = Kind("'router', 'peer' or 'client'", lambda value: value in MODES)
_ID = Kind(
    'up to 32 digits of 0-9 and a-f that do not begin with 0',
    lambda value: isinstance(value, str) and re.fullmatch('[1-9a-f][0-9a-f]{0,31}', value) is not None,
)
_RESOLUTION = Kind(
    "'8bit', '16bit', '32bit' or '64bit'",
    lambda value: value in ('8bit', '16bit', '32bit', '64bit'),
)
_BOOL_BY_MODE = _BOOL._replace(by_mode=True)
_NUMBER_BY_MODE = _NUMBER._replace(by_mode=True)
_ENDPOINTS = Kind(
    'a list of addresses like tcp/localhost:7447',
    lambda value: isinstance(value, list) and all(map(_is_endpoint, value)),
    by_mode=True,
)
_WHO = Kind(
    "a list of 'router', 'peer' and 'client'",
    lambda value: isinstance(value, list) and all(each in MODES for each in value),
    by_mode=True,
)
_STRATEGY = Kind(
    "'always' or 'greater-zid', or one for each mode",
    lambda value: value in ('always', 'greater-zid') or isinstance(value, dict),
)

_PLACE: Schema = {
    'timeout_ms': _NUMBER_BY_MODE,
    'endpoints': _ENDPOINTS,
    'exit_on_failure': _BOOL_BY_MODE,
    'retry': dict.fromkeys(('period_init_ms', 'period_max_ms', 'period_increase_factor'), _NUMBER_BY_MODE),
}
_TLS_TEXTS = (
    'root_ca_certificate',
    'listen_certificate',
    'listen_private_key',
    'connect_certificate',
    'connect_private_key',
)
_SCHEMA: Schema = {
    'id': _ID,
    'metadata': _ANY,
    'mode': _MODE,
    'region_name': _TEXT,
    'gateway': _ANY,
    'connect': _PLACE,
    'listen': _PLACE,
    'open': {'return_conditions': {'connect_scouted': _BOOL, 'declares': _BOOL}},
    'scouting': {
        'timeout': _COUNT,
        'delay': _COUNT,
        'multicast': {
            'enabled': _BOOL,
            'address': _TEXT,
            'interface': _TEXT,
            'ttl': _COUNT,
            'autoconnect': _WHO,
            'autoconnect_strategy': _STRATEGY,
            'listen': _BOOL_BY_MODE,
        },
        'gossip': {
            'enabled': _BOOL,
            'multihop': _BOOL,
            'target': _WHO,
            'autoconnect': _WHO,
            'autoconnect_strategy': _STRATEGY,
        },
    },
    'timestamping': {'enabled': _BOOL_BY_MODE, 'drop_future_timestamp': _BOOL},
    'queries_default_timeout': _COUNT,
    'routing': {
        'router': {'peers_failover_brokering': _BOOL, 'linkstate': _ANY},
        'peer': {'mode': _TEXT, 'linkstate': _ANY},
        'interests': {'timeout': _COUNT},
    },
    'aggregation': {'subscribers': _LIST, 'publishers': _LIST},
    'qos': {'publication': _LIST, 'network': _LIST},
    'transport': {
        'unicast': {
            'open_timeout': _COUNT,
            'accept_timeout': _COUNT,
            'accept_pending': _COUNT,
            'max_sessions': _COUNT,
            'max_links': _COUNT,
            'lowlatency': _BOOL,
            'qos': {'enabled': _BOOL},
            'compression': {'enabled': _BOOL},
        },
        'multicast': {
            'join_interval': _COUNT,
            'max_sessions': _COUNT,
            'qos': {'enabled': _BOOL},
            'compression': {'enabled': _BOOL},
        },
        'link': {
            'protocols': _LIST,
            'tx': {
                'sequence_number_resolution': _RESOLUTION,
                'lease': _COUNT,
                'keep_alive': _COUNT,
                'batch_size': _COUNT,
                'queue': {
                    'size': dict.fromkeys(
                        (
                            'control',
                            'real_time',
                            'interactive_high',
                            'interactive_low',
                            'data_high',
                            'data',
                            'data_low',
                            'background',
                        ),
                        _COUNT,
                    ),
                    'congestion_control': {
                        'drop': {'wait_before_drop': _NUMBER, 'max_wait_before_drop_fragments': _NUMBER},
                        'block': {'wait_before_close': _NUMBER},
                    },
                    'batching': {'enabled': _BOOL, 'time_limit': _COUNT},
                    'allocation': {'mode': _TEXT},
                },
                'threads': _COUNT,
            },
            'rx': {'buffer_size': _COUNT, 'max_message_size': _COUNT},
            'tls': {
                **dict.fromkeys(_TLS_TEXTS, _TEXT),
                **{f'{name}_base64': _TEXT for name in _TLS_TEXTS},
                'enable_mtls': _BOOL,
                'verify_name_on_connect': _BOOL,
                'close_link_on_expiration': _BOOL,
                'so_sndbuf': _COUNT,
                'so_rcvbuf': _COUNT,
            },
            'tcp': {'so_sndbuf': _COUNT, 'so_rcvbuf': _COUNT},
            'unixpipe': {'file_access_mask': _COUNT},
        },
        'shared_memory': {
            'enabled': _BOOL,
            'mode': _TEXT,
            'transport_optimization': {
                'enabled': _BOOL,
                'pool_size': _COUNT,
                'message_size_threshold': _COUNT,
                'messages': _LIST,
            },
        },
        'auth': {
            'usrpwd': dict.fromkeys(('user', 'password', 'dictionary_file'), _TEXT),
            'pubkey': {
                **dict.fromkeys(
                    (
                        'public_key_pem',
                        'private_key_pem',
                        'public_key_file',
                        'private_key_file',
                        'known_keys_file',
                    ),
                    _TEXT,
                ),
                'key_size': _COUNT,
            },
        },
    },
    'adminspace': {'enabled': _BOOL, 'permissions': {'read': _BOOL, 'write': _BOOL}},
    'namespace': _TEXT,
    'downsampling': _LIST,
    'access_control': _ANY,
    'low_pass_filter': _LIST,
    'stats': {'filters': _LIST},
    'plugins_loading': {'enabled': _BOOL, 'search_dirs': _LIST},
    'plugins': _ANY,
}


def find(path: str) -> Schema | Kind | None:
    """Return the schema at a path; None if no setting has that name."""
    found: Schema | Kind | None = _SCHEMA
    for name in path.split('/'):
        if found is _ANY:
            return _ANY
        found = found.get(name) if isinstance(found, dict) else None
    return found


def faults(value: Json, path: str = '', schema: Schema | Kind | None = None) -> Iterator[Fault]:
    """Yield the values that do not fit. Unknown names are not a fault."""
    schema = _SCHEMA if schema is None else schema
    if isinstance(schema, Kind):
        if not _fits(value, schema):
            yield Fault(path, schema.expected)
    elif not isinstance(value, dict):
        if value is not None:
            yield Fault(path, f'an object with {", ".join(schema)}')
    else:
        for name, each in value.items():
            if (known := schema.get(name)) is not None:
                yield from faults(each, f'{path}/{name}' if path else name, known)


def _fits(value: Json, kind: Kind) -> bool:
    if value is None or kind.fits(value):
        return True
    if not (kind.by_mode and isinstance(value, dict)):
        return False
    return all(mode in MODES and (each is None or kind.fits(each)) for mode, each in value.items())


def unknown(value: Json, path: str = '', schema: Schema | Kind | None = None) -> Iterator[str]:
    """Yield the paths of names that are not known."""
    schema = _SCHEMA if schema is None else schema
    if isinstance(schema, dict) and isinstance(value, dict):
        for name, each in value.items():
            where = f'{path}/{name}' if path else name
            known = schema.get(name)
            if known is None:
                yield where
            else:
                yield from unknown(each, where, known)


def of_mode(value: Json, mode: str) -> Json:
    """Return the value for a mode, if the setting has one value for each mode."""
    if isinstance(value, dict) and value and all(name in MODES for name in value):
        return value.get(mode)
    return value
