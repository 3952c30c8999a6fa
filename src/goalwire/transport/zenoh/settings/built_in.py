"""rmw_zenoh's session and router settings as data, and the few that goalwire changes, with the reasons.

Only what differs from the zenoh library's own defaults is listed. Source: rmw_zenoh_cpp
config/DEFAULT_RMW_ZENOH_{SESSION,ROUTER}_CONFIG.json5, the same from humble to rolling.

These variables of the environment are read, rmw_zenoh's own and goalwire's two:

    ZENOH_SESSION_CONFIG_URI, ZENOH_ROUTER_CONFIG_URI   a json5 file in place of the built-in settings
    ZENOH_CONFIG_OVERRIDE                               `key/path=json5;…` on top of either
    ZENOH_SHM_ALLOC_SIZE, ZENOH_SHM_MESSAGE_SIZE_THRESHOLD   bytes; sizes of shared memory, where it is on
    ZENOH_ROUTER_CHECK_ATTEMPTS                         how many seconds to look for a router before a warning
    GOALWIRE_ROUTER                                     auto, on, off: whether to offer a rendezvous
    GOALWIRE_ROUTER_PORT                                where it is offered and looked for (7447)

Source: rmw_zenoh_cpp src/detail/zenoh_config.cpp, zenoh_utils.cpp.
"""

from __future__ import annotations

import os
from collections.abc import Mapping
from enum import Enum
from typing import NamedTuple, TypeAlias

from goalwire.errors import TransportError
from goalwire.zenoh.io.endpoints import as_port

Json: TypeAlias = 'dict[str, Json] | list[Json] | str | int | float | bool | None'
Settings: TypeAlias = dict[str, Json]

DEFAULT_PORT = 7447
START_ROUTER = 'start one (ros2 router; beside an installed ROS 2 also ros2 run rmw_zenoh_cpp rmw_zenohd)'
"""What to do where no router answers."""


def advise_unreached(mode: str) -> str:
    """Return what to do if a session reaches nobody at its addresses; a client needs a router there."""
    check = 'check ZENOH_SESSION_CONFIG_URI, ZENOH_CONFIG_OVERRIDE and that these addresses can be reached'
    return f'{START_ROUTER}, or {check}' if mode == 'client' else check


_FAST_RETRY: Settings = {'period_init_ms': 100, 'period_max_ms': 400, 'period_increase_factor': 2}
"""rmw waits 1 s, 2 s, 4 s; a rendezvous that has moved to another process is found in under half a second."""

_QUEUE_SIZE: Settings = {'control': 16, 'data': 16}
"""Pieces of 64 KiB that may wait for a link, made when needed; rmw has 2. A message of 1 MB fits: so its
publisher does not wait piece by piece (to the callback 720 µs, not 1070), nor drop it on a busy machine. And
so do the declarations of 4000 endpoints: Zenoh hands them over on the thread that learns when a socket has
room again, and waits; where sockets hold little, the link was given up after a minute."""

_TO_LESSER: Settings = {'to_router': 'always', 'to_peer': 'greater-zid'}


def _common() -> Settings:
    return {
        'open': {'return_conditions': {'connect_scouted': True, 'declares': True}},
        'timestamping': {
            'enabled': {'router': True, 'peer': True, 'client': True},
            'drop_future_timestamp': False,
        },
        'queries_default_timeout': 600_000,
        'routing': {'interests': {'timeout': 10_000}},
        'transport': {
            'unicast': {
                'open_timeout': 60_000,
                'accept_timeout': 60_000,
                'accept_pending': 10_000,
                'max_sessions': 10_000,
                'max_links': 1,
                'lowlatency': False,
                'qos': {'enabled': True},
            },
            'link': {
                'tx': {
                    'lease': 60_000,
                    'keep_alive': 2,
                    'queue': {
                        'size': _QUEUE_SIZE,
                        'congestion_control': {'block': {'wait_before_close': 60_000_000}},
                    },
                },
            },
            'shared_memory': {
                'enabled': False,
                'mode': 'lazy',
                'transport_optimization': {
                    'enabled': True,
                    'pool_size': 50_331_648,
                    'message_size_threshold': 512,
                },
            },
        },
        'adminspace': {'enabled': True, 'permissions': {'read': True, 'write': False}},
    }


def _scouting(delay_ms: int, strategy: Settings) -> Settings:
    return {
        'timeout': 3000,
        'delay': delay_ms,
        'multicast': {'enabled': False, 'address': '224.0.0.224:7446', 'interface': 'auto', 'ttl': 1},
        'gossip': {
            'enabled': True,
            'multihop': False,
            'target': {'router': ['router', 'peer'], 'peer': ['router']},
            'autoconnect': {'router': [], 'peer': ['router', 'peer']},
            'autoconnect_strategy': strategy,
        },
    }


def session(port: int) -> Settings:
    """Return the settings of an ordinary session that meets others at a router on `port` of this machine.

    The scouting delay is what an open costs where no router answers, and mostly where one does: Zenoh 1.10.2
    misses the end of its own wait if the router's greeting overtakes its record of having connected. On
    loopback all is said within 3 ms; rmw's 500 buy nothing.
    """
    return _common() | {
        'mode': 'peer',
        'connect': {
            'endpoints': [f'tcp/localhost:{port}'],
            'timeout_ms': {'router': -1, 'peer': -1, 'client': 0},
            'exit_on_failure': {'router': False, 'peer': False, 'client': True},
            'retry': _FAST_RETRY,
        },
        'listen': {'endpoints': ['tcp/localhost:0'], 'timeout_ms': 0, 'exit_on_failure': True},
        'scouting': _scouting(5, {'peer': _TO_LESSER}),
    }


def rendezvous(port: int) -> Settings:
    """Return the settings of the router that every process offers on `port`, for this machine alone.

    Whoever comes second keeps trying to bind, so a survivor takes the port over when its holder dies.
    """
    settings = _common() | {
        'mode': 'router',
        'listen': {'endpoints': [f'tcp/127.0.0.1:{port}'], **SINGLE_BIND},
        'scouting': _scouting(0, {'router': {'to_router': 'always', 'to_peer': 'always'}}),
    }
    settings['routing'] = {'interests': {'timeout': 10_000}, 'router': {'peers_failover_brokering': False}}
    return settings


_MARK = b'goalwire'.hex()


def rendezvous_id() -> str:
    """Return a session id for a rendezvous; half of it tells that goalwire offers it, half is drawn."""
    return _MARK + os.urandom(8).hex()


def is_rendezvous_id(session: str) -> bool:
    """Return whether a session is a rendezvous of goalwire's, by its id."""
    return session.startswith(_MARK)


SINGLE_BIND: Settings = {'timeout_ms': 0, 'exit_on_failure': True}
"""How a rendezvous listens, whatever its endpoints: one attempt, repeated by rendezvous.Offer."""


class RendezvousChoice(Enum):
    """Whether this process offers a rendezvous; AUTO decides by the machine and the configuration."""

    AUTO = 'auto'
    ON = 'on'
    OFF = 'off'


class Override(NamedTuple):
    """One pair of ZENOH_CONFIG_OVERRIDE: a slash-separated path and a json5 text."""

    path: str
    value: str


def router_port(env: Mapping[str, str] = os.environ) -> int:
    """Return the rendezvous port; raises TransportError for something that is no port."""
    text = env.get('GOALWIRE_ROUTER_PORT') or str(DEFAULT_PORT)
    port = as_port(text)
    if not port:
        raise TransportError(f"GOALWIRE_ROUTER_PORT is '{text}'; set it to a port number from 1 to 65535")
    return port


def rendezvous_choice(env: Mapping[str, str] = os.environ) -> RendezvousChoice:
    """Return what GOALWIRE_ROUTER says; where rmw_zenoh is set up, and so rmw_zenohd, auto means off."""
    text = env.get('GOALWIRE_ROUTER') or 'auto'
    try:
        choice = RendezvousChoice(text)
    except ValueError:
        raise TransportError(f"GOALWIRE_ROUTER is '{text}'; set it to auto, on or off") from None
    if choice is RendezvousChoice.AUTO and _has_rmw_zenoh(env.get('AMENT_PREFIX_PATH', '')):
        return RendezvousChoice.OFF
    return choice


def _has_rmw_zenoh(prefixes: str) -> bool:
    """Whether a prefix of ament's has rmw_zenoh. A workspace without ROS 2 has prefixes, and no router."""
    return any(
        os.path.exists(f'{prefix}/share/ament_index/resource_index/packages/rmw_zenoh_cpp')  # noqa: PTH110
        for prefix in prefixes.split(os.pathsep)
        if prefix
    )


def overrides(env: Mapping[str, str] = os.environ) -> tuple[list[Override], list[str]]:
    """Return the pairs of ZENOH_CONFIG_OVERRIDE, and the parts of it that are no pairs."""
    pairs, broken = [], []
    for part in filter(None, (part.strip() for part in env.get('ZENOH_CONFIG_OVERRIDE', '').split(';'))):
        path, found, value = (text.strip() for text in part.partition('='))
        if path and found and value:
            pairs.append(Override(path, value))
        else:
            broken.append(part)
    return pairs, broken


def shared_memory(env: Mapping[str, str] = os.environ) -> Settings:
    """Return the shared memory sizes asked for, by zenoh's names; raises TransportError for a bad size."""
    sizes: Settings = {}
    if text := env.get('ZENOH_SHM_ALLOC_SIZE'):
        sizes['pool_size'] = _size('ZENOH_SHM_ALLOC_SIZE', text)
    if text := env.get('ZENOH_SHM_MESSAGE_SIZE_THRESHOLD'):
        threshold = _size('ZENOH_SHM_MESSAGE_SIZE_THRESHOLD', text)
        if threshold & (threshold - 1):
            raise TransportError(f'ZENOH_SHM_MESSAGE_SIZE_THRESHOLD is {text}; set it to a power of 2')
        sizes['message_size_threshold'] = threshold
    return sizes


def _size(name: str, text: str) -> int:
    if not (text.isascii() and text.isdigit() and int(text) > 0):
        raise TransportError(f"{name} is '{text}'; set it to a number of bytes above 0")
    return int(text)


def router_check_seconds(env: Mapping[str, str] = os.environ) -> float | None:
    """Return how long to look for a router: None not at all, infinity for ever.

    rmw checks n times, a second apart; so n attempts look for n - 1 seconds.
    """
    text = env.get('ZENOH_ROUTER_CHECK_ATTEMPTS') or '1'
    try:
        attempts = int(text)
    except ValueError:
        raise TransportError(
            f"ZENOH_ROUTER_CHECK_ATTEMPTS is '{text}'; set it to a whole number (0: for ever, -1: no check)"
        ) from None
    if attempts < 0:
        return None
    return attempts - 1.0 if attempts else float('inf')
