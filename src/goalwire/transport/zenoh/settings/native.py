"""Turns Zenoh's configuration into the settings of goalwire's own session.

Missing settings have Zenoh's own defaults. Settings that only tune eclipse-zenoh (its queues, threads and
buffers) are ignored. If goalwire's session would behave differently from the configuration, BeyondOursError
is raised.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import TypeAlias

from goalwire.errors import TransportError
from goalwire.transport.zenoh.settings import schema
from goalwire.transport.zenoh.settings.environment import advise_unreached
from goalwire.transport.zenoh.settings.values import Json, value_at
from goalwire.zenoh.io.dialler import Retry
from goalwire.zenoh.io.endpoints import TlsFiles, parse
from goalwire.zenoh.io.settings import MemorySettings, Settings
from goalwire.zenoh.protocol.link_messages import Role
from goalwire.zenoh.protocol.primitives import read_id

_ROLES = {'peer': Role.PEER, 'client': Role.CLIENT}
_LISTENS: dict[Role, Json] = {Role.PEER: ['tcp/[::]:0'], Role.CLIENT: []}
"""Zenoh's own default of listen/endpoints."""
ZENOH_POOL, ZENOH_LEAST = 16 << 20, 3072
"""Zenoh's own defaults of the pool's size and of the smallest message that goes through it, in bytes."""
PAYS_FROM = 1 << 16
"""The message size in bytes from which shared memory is faster than a socket between two Python programs:
see docs/adr/032-zenohs-shared-memory.md."""
_WITH_PEERS = (['router', 'peer'], ['peer', 'router'], ['peer'])


class BeyondOursError(Exception):
    """The error for a configuration beyond goalwire's own session: eclipse-zenoh is used then."""


_At: TypeAlias = Callable[[str], Json]
"""Returns the value at a path, for the session's mode."""


def native_settings(values: Json, *, shares_with_own: bool = False) -> Settings:
    """Return the settings of goalwire's own session.

    With `shares_with_own` the session shares memory with goalwire's programs on this machine, even if Zenoh's
    shared memory is off. Raises BeyondOursError, which names the unknown setting.
    """
    mode = str(value_at(values, 'mode') or 'peer')
    role = _ROLES.get(mode)
    if role is None:
        raise BeyondOursError(f"mode '{mode}'")
    for name in schema.unknown(values):
        raise BeyondOursError(f'{name}, which is not known here')

    def at(path: str) -> Json:
        return schema.of_mode(value_at(values, path), mode)

    _refuse(at, _OFF)
    identity = at('id')
    must_connect = at('connect/exit_on_failure')
    return Settings(
        role=role,
        advice=advise_unreached(mode),
        connect=_endpoints(at('connect/endpoints'), 'connect'),
        listen=_endpoints(_or(at('listen/endpoints'), _LISTENS[role]), 'listen'),
        zid=read_id(identity) if isinstance(identity, str) else b'',
        lease_ms=int(_number(at('transport/link/tx/lease'), 10_000)),
        retry=Retry(
            _number(at('connect/retry/period_init_ms'), 1000) / 1000,
            _number(at('connect/retry/period_max_ms'), 4000) / 1000,
            _number(at('connect/retry/period_increase_factor'), 2),
        ),
        open_s=_number(at('transport/unicast/open_timeout'), 10_000) / 1000,
        meets_peers=_meets_peers(at),
        memory=_memory(at, shares_with_own=shares_with_own),
        tls=_tls_files(at('transport/link/tls')),
        untimed_s=_number(at('queries_default_timeout'), 10_000) / 1000,
        must_connect=must_connect if isinstance(must_connect, bool) else None,
        connecting_s=_connecting_s(at('connect/timeout_ms')),
    )


def router_settings(values: Json) -> Settings:
    """Return the settings of goalwire's own router, for one machine.

    Raises BeyondOursError, which names the unknown setting. Access control is supported in one form only: if
    it forbids everything, the router only tells peers of each other.
    """
    for name in schema.unknown(values):
        raise BeyondOursError(f'{name}, which is not known here')

    def at(path: str) -> Json:
        return schema.of_mode(value_at(values, path), 'router')

    _refuse(at, _OFF_IN_ROUTER)
    forbids = at('access_control/enabled') is True
    if forbids and (at('access_control/default_permission') != 'deny' or at('access_control/rules')):
        raise BeyondOursError('access_control/rules')
    identity = at('id')
    return Settings(
        role=Role.ROUTER,
        listen=_endpoints(_or(at('listen/endpoints'), ['tcp/[::]:7447']), 'listen'),
        zid=read_id(identity) if isinstance(identity, str) else b'',
        lease_ms=int(_number(at('transport/link/tx/lease'), 10_000)),
        tls=_tls_files(at('transport/link/tls')),
        passes_on=not forbids,
    )


_OFF: dict[str, tuple[Json, ...]] = {
    'scouting/multicast/enabled': (False,),
    'scouting/gossip/multihop': (False, None),
    'transport/shared_memory/transport_optimization/messages': (None,),
    'transport/unicast/compression/enabled': (False, None),
    'transport/unicast/lowlatency': (False, None),
    'transport/unicast/qos/enabled': (True, None),
    'transport/link/tx/sequence_number_resolution': ('32bit', '64bit', None),
    'transport/link/tls/close_link_on_expiration': (False, None),
    'transport/auth/usrpwd/user': (None,),
    'transport/auth/usrpwd/dictionary_file': (None,),
    'transport/auth/pubkey/private_key_pem': (None,),
    'transport/auth/pubkey/private_key_file': (None,),
    'transport/auth/pubkey/known_keys_file': (None,),
    'access_control/enabled': (False, None),
    'routing/peer/mode': ('peer_to_peer', None),
    'timestamping/enabled': (True, None),
    'timestamping/drop_future_timestamp': (False, None),
    'listen/exit_on_failure': (True, None),
    'namespace': (None,),
    'region_name': (None,),
    'gateway': (None, {}, {'south': None}),
    'metadata': (None,),
    'aggregation/subscribers': ([], None),
    'aggregation/publishers': ([], None),
    'qos/publication': ([], None),
    'qos/network': ([], None),
    'downsampling': ([], None),
    'low_pass_filter': ([], None),
    'plugins': ({}, None),
    'plugins_loading/enabled': (False, None),
    'transport/link/protocols': (None,),
}
"""Settings that goalwire's sessions do not have, with the values that they may have nevertheless."""


_OFF_IN_ROUTER: dict[str, tuple[Json, ...]] = {
    **{path: wanted for path, wanted in _OFF.items() if path != 'access_control/enabled'},
    'mode': ('router',),
    'connect/endpoints': ([], None),
    'routing/router/peers_failover_brokering': (False,),
    'scouting/gossip/enabled': (True, None),
    'scouting/gossip/target': (['router', 'peer'], ['peer', 'router'], None),
    'scouting/gossip/autoconnect': ([], None),
}
"""Settings that goalwire's routers do not have, with the values that they may have nevertheless."""


def _refuse(at: _At, off: dict[str, tuple[Json, ...]]) -> None:
    """Raise BeyondOursError if a setting has a value that goalwire's own code does not support."""
    for path, wanted in off.items():
        if at(path) not in wanted:
            raise BeyondOursError(_setting(path, at(path)))
    links = at('transport/unicast/max_links')
    if isinstance(links, int) and links > 1:
        raise BeyondOursError(f'transport/unicast/max_links={links}')


def _setting(path: str, value: Json) -> str:
    import json  # imported here: it takes 2 ms, and few configurations name unknown settings

    return f'{path}={json.dumps(value)}'


def _or(value: Json, otherwise: Json) -> Json:
    return otherwise if value is None else value


def _meets_peers(at: _At) -> bool:
    """Return whether a session connects to the peers that routers announce to it."""
    if at('scouting/gossip/enabled') is False:
        return False
    told = at('scouting/gossip/target')
    # Zenoh's own default is refused: it also has 'peer', but goalwire's sessions tell only routers.
    if at('mode') != 'client' and told not in (['router'], []):
        raise BeyondOursError(_setting('scouting/gossip/target', told))
    who = at('scouting/gossip/autoconnect')
    if who in ([], ['router']):
        return False
    if who is not None and who not in _WITH_PEERS:
        raise BeyondOursError(_setting('scouting/gossip/autoconnect', who))
    return True


def _endpoints(found: Json, name: str) -> tuple[str, ...]:
    """Return the addresses in `connect/endpoints` or `listen/endpoints`, as `name` says."""
    checked = []
    for text in found if isinstance(found, list) else []:
        if not isinstance(text, str):
            raise BeyondOursError(f'a group of addresses in {name}/endpoints')
        if '#' in text or '?' in text:
            raise BeyondOursError(f"the address '{text}' in {name}/endpoints")
        try:
            parse(text)
        except TransportError as error:
            raise BeyondOursError(str(error)) from None
        checked.append(text)
    return tuple(checked)


def _tls_files(found: Json) -> TlsFiles:
    asked = found if isinstance(found, dict) else {}
    inline = [name for name, value in asked.items() if name.endswith('_base64') and value]
    if inline:
        raise BeyondOursError(f'transport/link/tls/{inline[0]}')

    def path(name: str) -> str:
        value = asked.get(name)
        return value if isinstance(value, str) else ''

    return TlsFiles(
        root_ca_certificate=path('root_ca_certificate'),
        listen_certificate=path('listen_certificate'),
        listen_private_key=path('listen_private_key'),
        connect_certificate=path('connect_certificate'),
        connect_private_key=path('connect_private_key'),
        enable_mtls=asked.get('enable_mtls') is True,
        verify_name_on_connect=asked.get('verify_name_on_connect') is not False,
    )


def _memory(at: _At, *, shares_with_own: bool) -> MemorySettings:
    """Return the settings of shared memory. Without settings memory is shared with everybody, as in Zenoh."""
    with_all = at('transport/shared_memory/enabled') is not False
    optimization = 'transport/shared_memory/transport_optimization'
    least = int(_number(at(f'{optimization}/message_size_threshold'), ZENOH_LEAST))
    return MemorySettings(
        with_own=with_all or shares_with_own,
        with_all=with_all,
        pool_size=int(_number(at(f'{optimization}/pool_size'), ZENOH_POOL)),
        least=least if with_all else max(least, PAYS_FROM),
    )


def _number(found: Json, otherwise: float) -> float:
    return found if isinstance(found, int | float) and found > 0 else otherwise


def _connecting_s(found: Json) -> float:
    """Return for how many s opening tries to connect; the setting -1 stands for ever."""
    return float('inf') if found == -1 else _number(found, 0) / 1000
