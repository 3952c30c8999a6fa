"""What a configuration of Zenoh's asks for, as settings of a session of our own."""

from __future__ import annotations

import json

from goalwire.errors import TransportError
from goalwire.transport.zenoh.native.dialler import Retry
from goalwire.transport.zenoh.native.endpoints import TlsFiles, parse
from goalwire.transport.zenoh.native.session import Settings
from goalwire.transport.zenoh.protocol.primitives import read_id
from goalwire.transport.zenoh.protocol.transport import Role
from goalwire.transport.zenoh.settings import Json

_ROLES = {'peer': Role.PEER, 'client': Role.CLIENT}


class BeyondOursError(Exception):
    """A configuration asks for what sessions of ours do not do."""


def native_settings(values: Json) -> Settings:
    """Return what a session of ours is opened with. Raises BeyondOursError, naming what it does not do."""
    role = _ROLES.get(str(_at(values, 'mode')))
    if role is None:
        raise BeyondOursError(f"mode '{_at(values, 'mode')}'")
    for path, wanted in _OFF.items():
        if _at(values, path) not in wanted:
            raise BeyondOursError(f'{path}={json.dumps(_at(values, path))}')
    connect = _endpoints(values, 'connect', role)
    listen = _endpoints(values, 'listen', role)
    retry = _at(values, 'connect/retry')
    retry = retry if isinstance(retry, dict) else {}
    identity = _at(values, 'id')
    return Settings(
        role=role,
        connect=connect,
        listen=listen,
        zid=read_id(identity) if isinstance(identity, str) else b'',
        lease_ms=_number(values, 'transport/link/tx/lease', 10_000),
        retry=Retry(
            _seconds(retry.get('period_init_ms'), 1.0),
            _seconds(retry.get('period_max_ms'), 4.0),
            float(str(retry.get('period_increase_factor') or 2)),
        ),
        meets_peers=_at(values, 'scouting/gossip/enabled') is not False,
        tls=_tls_files(values),
    )


_OFF: dict[str, tuple[Json, ...]] = {
    'scouting/multicast/enabled': (False,),
    'transport/shared_memory/enabled': (False,),
    'transport/unicast/compression/enabled': (False, None),
    'transport/unicast/lowlatency': (False, None),
    'transport/auth/usrpwd/user': (None,),
    'transport/auth/pubkey/private_key_pem': (None,),
    'transport/auth/pubkey/private_key_file': (None,),
    'access_control/enabled': (False, None),
    'scouting/gossip/multihop': (False, None),
    'routing/peer/mode': ('peer_to_peer', None),
    'namespace': (None,),
    'transport/link/tls/close_link_on_expiration': (False, None),
}
"""What must not be asked for, with the values that do not."""


def _at(values: Json, path: str) -> Json:
    for name in path.split('/'):
        values = values.get(name) if isinstance(values, dict) else None
    return values


def _endpoints(values: Json, name: str, role: Role) -> tuple[str, ...]:
    """Return the addresses of one kind; they may be a list, or one for each mode."""
    found = _at(values, f'{name}/endpoints')
    if isinstance(found, dict):
        found = found.get(role.name.lower(), [])
    texts = [found] if isinstance(found, str) else found
    if not isinstance(texts, list):
        return ()
    checked = []
    for text in texts:
        if not isinstance(text, str):
            raise BeyondOursError(f'groups of endpoints in {name}/endpoints')
        try:
            parse(text)
        except TransportError as error:
            raise BeyondOursError(str(error)) from None
        checked.append(text)
    return tuple(checked)


def _tls_files(values: Json) -> TlsFiles:
    found = _at(values, 'transport/link/tls')
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


def _number(values: Json, path: str, otherwise: int) -> int:
    found = _at(values, path)
    return found if isinstance(found, int) and found > 0 else otherwise


def _seconds(milliseconds: Json, otherwise: float) -> float:
    return milliseconds / 1000 if isinstance(milliseconds, int | float) and milliseconds > 0 else otherwise
