"""Makes a session's configuration: built-in settings or a file, then the overrides."""

from __future__ import annotations

import json
import os
from collections.abc import Sequence
from typing import NamedTuple

import zenoh

from goalwire.errors import TransportError
from goalwire.transport.reports import LOGGER
from goalwire.transport.zenoh import settings
from goalwire.transport.zenoh.settings import Json, Override, RendezvousChoice

_OF_THE_SESSION = ('mode', 'id', 'connect', 'listen', 'scouting')
"""Overrides that place a session in the network; the rendezvous of the same process keeps its own place."""

_LOCAL_HOSTS = ('localhost', '127.0.0.1', '[::1]')


class Plan(NamedTuple):
    """What to open: the session, and the rendezvous beside it (None: none) with its port."""

    session: zenoh.Config
    rendezvous: zenoh.Config | None
    port: int
    local: int | None
    """The TCP port of this machine that the session connects to; None: it connects elsewhere."""
    gives_way: bool
    """Whether the rendezvous leaves its port to a router that is no goalwire process's."""


def plan() -> Plan:
    """Read the environment; raises TransportError naming the variable or file and the reason."""
    port = settings.router_port()
    session, accepted = _session_config(port)
    choice = settings.rendezvous_choice()
    local = local_port(_value(session, 'connect/endpoints'), str(_value(session, 'mode')))
    if choice is RendezvousChoice.OFF or (choice is RendezvousChoice.AUTO and local is None):
        return Plan(session, None, port, local, gives_way=True)
    port = local or port
    gives_way = choice is RendezvousChoice.AUTO
    return Plan(session, _rendezvous_config(port, accepted), port, local, gives_way=gives_way)


def _session_config(port: int) -> tuple[zenoh.Config, list[Override]]:
    """Return the session's configuration and the overrides that zenoh took."""
    config = _from_file('ZENOH_SESSION_CONFIG_URI') or _from_settings(settings.session(port))
    for name, size in settings.shared_memory().items():
        config.insert_json5(f'transport/shared_memory/transport_optimization/{name}', str(size))
    pairs, broken = settings.overrides()
    for part in broken:
        _warn(part, 'it is not of the form key/path=value')
    return config, [pair for pair in pairs if _override(config, pair)]


def _rendezvous_config(port: int, overrides: list[Override]) -> zenoh.Config:
    config = _from_file('ZENOH_ROUTER_CONFIG_URI')
    if config is None:
        config = _from_settings(settings.rendezvous(port))
    else:
        for name, value in settings.SINGLE_BIND.items():
            config.insert_json5(f'listen/{name}', json.dumps(value))
    for pair in overrides:
        if pair.path.split('/')[0] not in _OF_THE_SESSION:
            _override(config, pair)
    if _value(config, 'id') is None:
        config.insert_json5('id', json.dumps(settings.rendezvous_id()))
    return config


def router_config(port: int, listen: Sequence[str], connect: Sequence[str]) -> zenoh.Config:
    """Return the settings of a router for a site, which listens on `port` of every address where not said.

    Raises TransportError.
    """
    config = _from_file('ZENOH_ROUTER_CONFIG_URI') or _from_settings(settings.rendezvous(port))
    try:
        if listen or not os.environ.get('ZENOH_ROUTER_CONFIG_URI'):
            config.insert_json5('listen/endpoints', json.dumps(list(listen) or [f'tcp/[::]:{port}']))
        if connect:
            config.insert_json5('connect/endpoints', json.dumps(list(connect)))
    except zenoh.ZError as error:
        raise TransportError(
            f'the router cannot be set up: {reason(error)}; write addresses like tcp/192.168.0.7:7447'
        ) from None
    for pair in settings.overrides()[0]:
        _override(config, pair)
    return config


def _from_settings(values: settings.Settings) -> zenoh.Config:
    return zenoh.Config.from_json5(json.dumps(values))


def _from_file(variable: str) -> zenoh.Config | None:
    uri = os.environ.get(variable)
    if not uri:
        return None
    path = _path_of(uri) if uri.startswith('file://') else uri
    try:
        return zenoh.Config.from_file(path)
    except zenoh.ZError as error:
        raise TransportError(
            f"{variable} names '{path}', which cannot be used: {reason(error)}; "
            f'correct the file or unset {variable}'
        ) from None


def _path_of(uri: str) -> str:
    from urllib.parse import unquote, urlsplit  # 2 ms, and few name a file this way

    return unquote(urlsplit(uri).path)


def reason(error: Exception) -> str:
    """Return zenoh's words without the place in its source."""
    return str(error).partition(' at /')[0].strip()


def _override(config: zenoh.Config, pair: Override) -> bool:
    """Apply one pair; what zenoh refuses is reported and ignored, as rmw_zenoh does."""
    try:
        config.insert_json5(pair.path, pair.value)
    except zenoh.ZError as error:
        if not _insert_into_parent(config, pair):
            _warn(f'{pair.path}={pair.value}', reason(error))
            return False
    return True


def _insert_into_parent(config: zenoh.Config, pair: Override) -> bool:
    """Set a key that zenoh takes only within its parent ('connect/retry/period_init_ms'); True if taken."""
    parent, _, name = pair.path.rpartition('/')
    try:
        siblings = _value(config, parent)
        if not isinstance(siblings, dict):
            return False
        siblings.pop(name, None)
        rest = json.dumps(siblings)[1:-1]
        config.insert_json5(parent, f'{{"{name}": {pair.value}{", " if rest else ""}{rest}}}')
        now = _value(config, parent)
    except zenoh.ZError:
        return False
    return isinstance(now, dict) and name in now


def _warn(part: str, why: str) -> None:
    from goalwire.logging import get_logger  # needed only when something is broken

    get_logger(LOGGER).warning(
        f"ZENOH_CONFIG_OVERRIDE: '{part}' is ignored: {why}; correct it or take it out"
    )


def _value(config: zenoh.Config, path: str) -> Json:
    value: Json = json.loads(config.get_json(path))
    return value


def local_port(endpoints: Json, mode: str) -> int | None:
    """Return the TCP port of this machine among `connect/endpoints`, or None.

    `endpoints` is a list, or one per mode; its members are strings or groups of them.
    """
    if isinstance(endpoints, dict):
        endpoints = endpoints.get(mode, endpoints.get('locators'))
    if isinstance(endpoints, str):
        endpoints = [endpoints]
    for endpoint in endpoints if isinstance(endpoints, list) else []:
        if isinstance(endpoint, str):
            scheme, _, address = endpoint.partition('/')
            host, _, port = address.partition('#')[0].partition('?')[0].rpartition(':')
            if scheme == 'tcp' and host in _LOCAL_HOSTS and port.isdigit():
                return int(port)
        elif (port_within := local_port(endpoint, mode)) is not None:
            return port_within
    return None
