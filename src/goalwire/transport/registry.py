"""The available transports; RMW_IMPLEMENTATION chooses one."""

from __future__ import annotations

import os
from importlib import import_module

from goalwire.errors import TransportError
from goalwire.transport import wrappers
from goalwire.transport.contract import Transport

DEFAULT = 'rmw_zenoh_cpp'
WITHIN_ONE_PROCESS = 'goalwire_memory'
"""The transport that stays within one process."""
_MODULES = {
    'rmw_zenoh_cpp': 'goalwire.transport.zenoh',
    'rmw_cyclonedds_cpp': 'goalwire.transport.dds',
    'rmw_fastrtps_cpp': 'goalwire.transport.dds',
    'rmw_connextdds': 'goalwire.transport.dds',
    WITHIN_ONE_PROCESS: 'goalwire.transport.memory',
}
_loaded: dict[str, Transport] = {}


def available() -> set[str]:
    """Return the identifiers that RMW_IMPLEMENTATION may name."""
    return set(_MODULES)


def select_identifier() -> str:
    """Return the value of RMW_IMPLEMENTATION, or the default."""
    return os.environ.get('RMW_IMPLEMENTATION') or DEFAULT


def get(identifier: str | None = None) -> Transport:
    """Return a transport by its identifier; raises TransportError for an unknown one."""
    identifier = identifier or select_identifier()
    if identifier not in _loaded:
        try:
            module = import_module(_MODULES[identifier])
        except KeyError:
            known = ', '.join(sorted(_MODULES))
            raise TransportError(
                f"RMW_IMPLEMENTATION names '{identifier}', which goalwire does not speak; "
                f'choose one of: {known}'
            ) from None
        _loaded[identifier] = getattr(module, 'TRANSPORTS', {}).get(identifier) or module.TRANSPORT
    transport = _loaded[identifier]
    if text := os.environ.get('GOALWIRE_FAULTS'):
        from goalwire.transport.faults.text import parse

        transport = parse(text).over(transport)
    return wrappers.wrap(transport)
