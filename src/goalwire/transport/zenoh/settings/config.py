"""Makes a session's configuration: built-in settings or a file, then the overrides.

It is read here, without eclipse-zenoh: a process whose session is goalwire's own need not import that.
"""

from __future__ import annotations

import os
from collections.abc import Sequence
from copy import deepcopy
from typing import NamedTuple

from goalwire.errors import TransportError
from goalwire.reports import LOGGER
from goalwire.transport.zenoh.settings import built_in, json5, schema
from goalwire.transport.zenoh.settings.built_in import Json, Override, RendezvousChoice, Settings
from goalwire.zenoh.io.endpoints import as_port

_OF_THE_SESSION = ('mode', 'id', 'connect', 'listen', 'scouting')
"""Overrides that place a session in the network; the rendezvous of the same process keeps its own place."""

_LOCAL_HOSTS = ('localhost', '127.0.0.1', '[::1]')


class Configuration(NamedTuple):
    """What one session is opened with."""

    values: Settings
    origin: str = ''
    """The variable and the file that it comes from; empty: the built-in settings."""

    def at(self, path: str) -> Json:
        """Return one value; None where it is not set."""
        return value_at(self.values, path)

    def set(self, path: str, value: Json) -> None:
        """Set one value, and leave those beside it as they are."""
        *parents, name = path.split('/')
        within = self.values
        for each in parents:
            inner = within.get(each)
            if not isinstance(inner, dict):
                inner = within[each] = {}
            within = inner
        within[name] = value


def value_at(values: Json, path: str) -> Json:
    """Return the value at a path; None where there is none."""
    for name in path.split('/'):
        values = values.get(name) if isinstance(values, dict) else None
    return values


class Plan(NamedTuple):
    """What is to be opened: the session, and the rendezvous beside it (None: none) with its port."""

    session: Configuration
    rendezvous: Configuration | None
    port: int
    local: int | None
    """The TCP port of this machine that the session connects to; None: it connects elsewhere."""
    gives_way: bool
    """Whether the rendezvous leaves its port to a router that is no goalwire process's."""


def plan() -> Plan:
    """Read the environment; raises TransportError naming the variable or file and the reason."""
    port = built_in.router_port()
    session, accepted = _session_config(port)
    choice = built_in.rendezvous_choice()
    local = local_port(session.at('connect/endpoints'), str(session.at('mode') or 'peer'))
    if choice is RendezvousChoice.OFF or (choice is RendezvousChoice.AUTO and local is None):
        return Plan(session, None, port, local, gives_way=True)
    port = local or port
    gives_way = choice is RendezvousChoice.AUTO
    return Plan(session, _rendezvous_config(port, accepted), port, local, gives_way=gives_way)


def _session_config(port: int) -> tuple[Configuration, list[tuple[str, Json]]]:
    """Return the session's configuration, and the overrides that hold."""
    config = _from_file('ZENOH_SESSION_CONFIG_URI') or _built_in(built_in.session(port))
    for name, size in built_in.shared_memory().items():
        config.set(f'transport/shared_memory/transport_optimization/{name}', size)
    accepted = _read_overrides()
    for path, value in accepted:
        config.set(path, value)
    return config, accepted


def _rendezvous_config(port: int, overrides: list[tuple[str, Json]]) -> Configuration:
    config = _from_file('ZENOH_ROUTER_CONFIG_URI')
    if config is None:
        config = _built_in(built_in.rendezvous(port))
    else:
        for name, value in built_in.SINGLE_BIND.items():
            config.set(f'listen/{name}', value)
    for path, value in overrides:
        if path.split('/')[0] not in _OF_THE_SESSION:
            config.set(path, value)
    if config.at('id') is None:
        config.set('id', built_in.rendezvous_id())
    return config


def router_config(port: int, listen: Sequence[str], connect: Sequence[str]) -> Configuration:
    """Return the settings of a router for a site, which listens on `port` of every address where not said.

    Raises TransportError.
    """
    config = _from_file('ZENOH_ROUTER_CONFIG_URI') or _built_in(built_in.rendezvous(port))
    if listen or not os.environ.get('ZENOH_ROUTER_CONFIG_URI'):
        config.set('listen/endpoints', list(listen) or [f'tcp/[::]:{port}'])
    if connect:
        config.set('connect/endpoints', list(connect))
    for path, value in _read_overrides():
        config.set(path, value)
    for fault in schema.faults(config.values):
        raise TransportError(
            f'the router cannot be set up: {fault.path} takes {fault.expected}; '
            f'write addresses like tcp/192.168.0.7:7447'
        )
    return config


def _built_in(values: Settings) -> Configuration:
    return Configuration(deepcopy(values))


def _from_file(variable: str) -> Configuration | None:
    uri = os.environ.get(variable)
    if not uri:
        return None
    path = _path_of(uri) if uri.startswith('file://') else uri
    try:
        with open(path, encoding='utf-8-sig') as file:  # noqa: PTH123 - pathlib opens by it
            text = file.read()
    except (OSError, ValueError) as error:
        reason = error.strerror if isinstance(error, OSError) else 'it is not text in UTF-8'
        raise _unusable(variable, path, reason or str(error)) from None
    try:
        values = read_settings(text, is_yaml=path.endswith(('.yaml', '.yml')))
    except json5.Json5Error as error:
        raise _unusable(variable, path, str(error)) from None
    return Configuration(values, f"{variable} names '{path}'")


def read_settings(text: str, *, is_yaml: bool) -> Settings:
    """Return what a configuration file's text sets. Raises Json5Error, with the line where it is known."""
    document = _from_yaml(text) if is_yaml else json5.read(text)
    values = document.value
    if not isinstance(values, dict):
        raise json5.Json5Error('it holds no object: { … }')
    for fault in schema.faults(values):
        line = _line_of(fault.path, document.lines)
        raise json5.Json5Error(f'{line}{fault.path} takes {fault.expected}')
    return values


def _line_of(path: str, lines: dict[str, int]) -> str:
    while path and path not in lines:
        path = path.rpartition('/')[0]
    return f'line {lines[path]}: ' if path else ''


def _from_yaml(text: str) -> json5.Document:
    import yaml  # 20 ms, and few write the file so

    try:
        return json5.Document(yaml.safe_load(text), {})
    except (
        yaml.YAMLError,
        ValueError,
        RecursionError,
    ) as error:  # ValueError: for a date that does not exist
        raise json5.Json5Error(' '.join(str(error).split())) from None


def _unusable(variable: str, path: str, reason: str) -> TransportError:
    return TransportError(
        f"{variable} names '{path}', which cannot be used: {reason}; correct the file or unset {variable}"
    )


def _path_of(uri: str) -> str:
    from urllib.parse import unquote, urlsplit  # 2 ms, and few name a file this way

    return unquote(urlsplit(uri).path)


def _read_overrides() -> list[tuple[str, Json]]:
    """Return the pairs of ZENOH_CONFIG_OVERRIDE that hold; rmw_zenoh too reports others and goes on."""
    pairs, broken = built_in.overrides()
    for part in broken:
        _warn(part, 'it is not of the form key/path=value')
    accepted = []
    for pair in pairs:
        path = pair.path.strip('/')
        try:
            value = json5.read(pair.value).value
        except json5.Json5Error as error:
            _warn_of(pair, f'its value is no JSON5: {error}')
            continue
        known = schema.find(path)
        if known is None:
            _warn_of(pair, f"'{path}' is no setting of Zenoh's")
            continue
        wrong = next(schema.faults(value, path, known), None) or next(
            (schema.Fault(each, 'no such setting') for each in schema.unknown(value, path, known)), None
        )
        if wrong is not None:
            _warn_of(pair, f'{wrong.path} takes {wrong.expected}')
            continue
        accepted.append((path, value))
    return accepted


def _warn_of(pair: Override, why: str) -> None:
    _warn(f'{pair.path}={pair.value}', why)


def _warn(part: str, why: str) -> None:
    from goalwire.logging import get_logger  # needed only when something is broken

    get_logger(LOGGER).warning(
        f"ZENOH_CONFIG_OVERRIDE: '{part}' is ignored: {why}; correct it or take it out"
    )


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
            if scheme == 'tcp' and host in _LOCAL_HOSTS and (number := as_port(port)) is not None:
                return number
        elif (port_within := local_port(endpoint, mode)) is not None:
            return port_within
    return None
