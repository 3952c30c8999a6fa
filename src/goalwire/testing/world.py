"""Isolates a test: its programs discover only each other, whatever else runs on the machine."""

from __future__ import annotations

import os
import socket
from itertools import count
from typing import TYPE_CHECKING, Self

from goalwire.errors import LocalError

if TYPE_CHECKING:
    from types import TracebackType

TRANSPORTS = {'memory': 'goalwire_memory', 'zenoh': 'rmw_zenoh_cpp', 'dds': 'rmw_cyclonedds_cpp'}
"""The transports: the name of each in tests, and its value of RMW_IMPLEMENTATION."""

_OTHERS = (
    'CYCLONEDDS_URI',
    'GOALWIRE_FAULTS',
    'ROS_LOCALHOST_ONLY',
    'ROS_STATIC_PEERS',
    'ZENOH_CONFIG_OVERRIDE',
    'ZENOH_ROUTER_CONFIG_URI',
    'ZENOH_SESSION_CONFIG_URI',
)
"""Environment variables that could connect the test to other programs; they are unset."""

_FIRST_DOMAIN, _DOMAINS = 1, 100  # DDS computes port numbers from domains, which must be below about 230
_FIRST_PORT = 18_700
"""The first of the ports that stand for domains: the test that holds a port owns the domain."""

_memory_domains = count(1000)


class World:
    """The environment variables of one graph, which are set in this process until `close`."""

    def __init__(self, transport: str) -> None:
        """Raises LocalError for an unknown transport, or if the machine has no domain left."""
        if transport not in TRANSPORTS:
            raise LocalError(f"no transport is called '{transport}'; choose {', '.join(TRANSPORTS)}")
        self.transport = transport
        self._claim: socket.socket | None = None
        self.domain = next(_memory_domains) if transport == 'memory' else self._take_domain()
        self.variables = {'RMW_IMPLEMENTATION': TRANSPORTS[transport], 'ROS_DOMAIN_ID': str(self.domain)}
        if transport != 'memory':
            self.variables['ROS_AUTOMATIC_DISCOVERY_RANGE'] = 'LOCALHOST'
            self.variables['GOALWIRE_ROUTER_PORT'] = str(_FIRST_PORT + _DOMAINS + self.domain)
        touched = [*_OTHERS, *self.variables]
        self._before = {name: os.environ.get(name) for name in touched}
        for name in _OTHERS:
            os.environ.pop(name, None)
        os.environ.update(self.variables)

    def _take_domain(self) -> int:
        for number in range(_FIRST_DOMAIN, _FIRST_DOMAIN + _DOMAINS):
            claim = socket.socket()
            try:
                claim.bind(('127.0.0.1', _FIRST_PORT + number))
            except OSError:
                claim.close()
            else:
                self._claim = claim
                return number
        raise LocalError(f'{_DOMAINS} graphs are open on this machine: close some')

    def close(self) -> None:
        """Restore the environment variables. Idempotent."""
        for name, value in self._before.items():
            if value is None:
                os.environ.pop(name, None)
            else:
                os.environ[name] = value
        self._before = {}
        if self._claim is not None:
            self._claim.close()

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.close()
