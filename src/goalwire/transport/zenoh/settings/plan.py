"""Makes the plan of a process's session and rendezvous, each from built-in settings or a file.

ZENOH_CONFIG_OVERRIDE applies to both.
"""

from __future__ import annotations

import os
from collections.abc import Sequence
from copy import deepcopy
from typing import TYPE_CHECKING, NamedTuple

from goalwire.errors import TransportError
from goalwire.transport.zenoh.settings import built_in, environment, schema
from goalwire.transport.zenoh.settings.environment import RendezvousChoice
from goalwire.transport.zenoh.settings.reader import read_file, read_overrides
from goalwire.transport.zenoh.settings.values import Configuration, Json, Settings
from goalwire.zenoh.io.endpoints import as_port

if TYPE_CHECKING:
    from goalwire.security.environment import Chosen

_OF_THE_SESSION = ('mode', 'id', 'connect', 'listen', 'scouting')
"""The settings that place a session in the network. Overrides of these do not apply to the rendezvous."""

_LOCAL_HOSTS = ('localhost', '127.0.0.1', '[::1]')


class Plan(NamedTuple):
    """The session to open, and the rendezvous to offer beside it, with its port."""

    session: Configuration
    rendezvous: Configuration | None
    """None if this process offers no rendezvous."""
    port: int
    local: int | None
    """The TCP port of this machine that the session connects to; None if it connects elsewhere."""
    gives_way: bool
    """True if the rendezvous leaves its port to a router that does not belong to goalwire."""


def make_plan(identity: Chosen | None = None) -> Plan:
    """Read the environment; raises TransportError naming the variable or file and the reason.

    With an identity all links have mutual TLS.
    """
    port = environment.router_port()
    session, accepted = _session_config(port, identity)
    choice = environment.rendezvous_choice()
    protocol = 'tcp' if identity is None else 'tls'
    local = local_port(session.at('connect/endpoints'), str(session.at('mode') or 'peer'), protocol)
    if choice is RendezvousChoice.OFF or (choice is RendezvousChoice.AUTO and local is None):
        return Plan(session, None, port, local, gives_way=True)
    port = local or port
    gives_way = choice is RendezvousChoice.AUTO
    rendezvous = _rendezvous_config(port, accepted, identity)
    return Plan(session, rendezvous, port, local, gives_way=gives_way)


def _session_config(port: int, identity: Chosen | None) -> tuple[Configuration, list[tuple[str, Json]]]:
    """Return the session's configuration, and the valid overrides."""
    config = read_file('ZENOH_SESSION_CONFIG_URI')
    if config is None:
        config = _copy_built_in(built_in.session(port))
        if identity is not None:
            built_in.protect_session(config.values, port)
    for name, size in environment.shared_memory().items():
        config.set(f'transport/shared_memory/transport_optimization/{name}', size)
    accepted = read_overrides()
    for path, value in accepted:
        config.set(path, value)
    _show_identity(config, identity)
    return config, accepted


def _show_identity(config: Configuration, identity: Chosen | None) -> None:
    if identity is not None:
        config.set('transport/link/tls', built_in.tls_of_identity(identity))


def _rendezvous_config(
    port: int, overrides: list[tuple[str, Json]], identity: Chosen | None
) -> Configuration:
    config = read_file('ZENOH_ROUTER_CONFIG_URI')
    if config is None:
        config = _copy_built_in(built_in.rendezvous(port))
        if identity is not None:
            built_in.protect_rendezvous(config.values, port)
    else:
        for name, value in built_in.SINGLE_BIND.items():
            config.set(f'listen/{name}', value)
    for path, value in overrides:
        if path.split('/')[0] not in _OF_THE_SESSION:
            config.set(path, value)
    if config.at('id') is None:
        config.set('id', built_in.rendezvous_id())
    _show_identity(config, identity)
    return config


def router_config(
    port: int,
    listen: Sequence[str],
    connect: Sequence[str],
    identity: Chosen | None = None,
    rules: Settings | None = None,
) -> Configuration:
    """Return the settings of a router for a site. Without addresses it listens on `port` of all addresses.

    With an identity all its links have mutual TLS, and the access control `rules` apply. Raises
    TransportError.
    """
    config = read_file('ZENOH_ROUTER_CONFIG_URI') or _copy_built_in(built_in.rendezvous(port))
    if listen or not os.environ.get('ZENOH_ROUTER_CONFIG_URI'):
        everywhere: list[Json] = [f'tcp/[::]:{port}'] if identity is None else built_in.everywhere(port)
        config.set('listen/endpoints', [*listen] or everywhere)
    if connect:
        config.set('connect/endpoints', list(connect))
    for path, value in read_overrides():
        config.set(path, value)
    if identity is not None:
        _show_identity(config, identity)
        config.set('transport/link/tls/close_link_on_expiration', True)
        config.set('access_control', rules)
        _refuse_plain(config)
    for fault in schema.faults(config.values):
        raise TransportError(
            f'the router cannot be set up: {fault.path} takes {fault.expected}; '
            f'write addresses like tcp/192.168.0.7:7447'
        )
    return config


def _refuse_plain(config: Configuration) -> None:
    """Raise TransportError if a router with rules would also let in sessions without a certificate."""
    for name in ('listen', 'connect'):
        endpoints = config.at(f'{name}/endpoints')
        for each in endpoints if isinstance(endpoints, list) else [endpoints]:
            if each is not None and not str(each).startswith('tls/'):
                raise TransportError(f"the router is to be secure, and '{each}' is not: write tls/HOST:PORT")


def _copy_built_in(values: Settings) -> Configuration:
    return Configuration(deepcopy(values))


def local_port(endpoints: Json, mode: str, protocol: str = 'tcp') -> int | None:
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
            if scheme == protocol and host in _LOCAL_HOSTS and (number := as_port(port)) is not None:
                return number
        elif (port_within := local_port(endpoint, mode, protocol)) is not None:
            return port_within
    return None
