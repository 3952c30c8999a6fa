"""rmw_zenoh's session and router settings as data, and the few that goalwire changes, with the reasons.

Only differences from the zenoh library's own defaults are listed. Source: rmw_zenoh_cpp
config/DEFAULT_RMW_ZENOH_{SESSION,ROUTER}_CONFIG.json5, the same from humble to rolling.
"""

from __future__ import annotations

import os
from contextlib import closing
from typing import TYPE_CHECKING

from goalwire.transport.zenoh.settings.values import Json, Settings

if TYPE_CHECKING:
    from goalwire.security.environment import Chosen

_FAST_RETRY: Settings = {'period_init_ms': 100, 'period_max_ms': 400, 'period_increase_factor': 2}
"""Pauses short enough to find a moved rendezvous within half a second; rmw_zenoh waits 1, 2, 4 s."""

_QUEUE_SIZE: Settings = {'control': 16, 'data': 16}
"""How many batches of 64 KiB may wait for a link, allocated when needed; rmw_zenoh has 2. A message of 1 MB
fits. So its publisher does not wait batch by batch (it arrives after 720 µs, not 1070), and does not drop it
on a busy machine. The declarations of 4000 endpoints fit, too. Zenoh sends these on the thread that learns
when a socket has room again, and waits for room there: with small sockets the link was closed after a
minute."""

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

    To open a session takes the scouting delay if no router answers, and mostly also if one does: Zenoh 1.10.2
    misses the end of its own wait if the router's greeting arrives before the connection is recorded. On
    loopback the exchange takes 3 ms; rmw_zenoh's delay of 500 ms has no benefit.
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
    """Return the settings of the router that every process offers on `port`, only for this machine.

    A second process keeps trying to bind, so a survivor takes the port over when its holder dies.
    """
    settings = _common() | {
        'mode': 'router',
        'listen': {'endpoints': [f'tcp/127.0.0.1:{port}'], **SINGLE_BIND},
        'scouting': _scouting(0, {'router': {'to_router': 'always', 'to_peer': 'always'}}),
    }
    settings['routing'] = {'interests': {'timeout': 10_000}, 'router': {'peers_failover_brokering': False}}
    return settings


def protect_session(settings: Settings, port: int) -> None:
    """Make a built-in session use TLS and listen for all machines, since TLS keeps strangers out."""
    settings['connect'] = {**_dict(settings, 'connect'), 'endpoints': [f'tls/localhost:{port}']}
    settings['listen'] = {**_dict(settings, 'listen'), 'endpoints': everywhere(0)}


def protect_rendezvous(settings: Settings, port: int) -> None:
    """Make the rendezvous use TLS and forward no data, only tell peers of each other: it has no policy."""
    settings['listen'] = {**_dict(settings, 'listen'), 'endpoints': everywhere(port)}
    settings['access_control'] = {
        'enabled': True,
        'default_permission': 'deny',
        'rules': [],
        'subjects': [],
        'policies': [],
    }


def everywhere(port: int) -> list[Json]:
    """Return the addresses at which a protected session listens: all of this machine, IPv6 or not."""
    import _socket  # `socket` takes 5 ms to import, and must not be imported while Ctrl-C ends the program

    try:
        with closing(_socket.socket(_socket.AF_INET6, _socket.SOCK_STREAM)) as probe:
            probe.bind(('::', 0))
    except OSError:
        return [f'tls/0.0.0.0:{port}']  # all addresses: TLS keeps strangers out
    return [f'tls/[::]:{port}']


def tls_of_identity(identity: Chosen) -> Settings:
    """Return the settings of mutual TLS: the certificate that all trust, and the file of an identity.

    A certificate names an identity and not a host, so host names are not compared. The session takes the
    identity from the certificate, and its policy decides if that identity is known.
    """
    names = ('listen_certificate', 'listen_private_key', 'connect_certificate', 'connect_private_key')
    own = dict.fromkeys(names, str(identity.identity_path))
    trust = str(identity.folder / 'trust.pem')
    return {'root_ca_certificate': trust, 'enable_mtls': True, 'verify_name_on_connect': False, **own}


def _dict(settings: Settings, name: str) -> Settings:
    found = settings[name]
    assert isinstance(found, dict)
    return found


_MARK = b'goalwire'.hex()


def rendezvous_id() -> str:
    """Return a session id for a rendezvous: one half of the id marks goalwire, the other half is random."""
    return _MARK + os.urandom(8).hex()


def is_rendezvous_id(session: str) -> bool:
    """Return whether a session is goalwire's rendezvous, by its id."""
    return session.startswith(_MARK)


SINGLE_BIND: Settings = {'timeout_ms': 0, 'exit_on_failure': True}
"""The settings with which a rendezvous tries to listen only once; rendezvous.EmbeddedRouter tries again."""
