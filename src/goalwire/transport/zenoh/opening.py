"""Which session is opened: one of goalwire's own, or eclipse-zenoh's.

GOALWIRE_ZENOH says which: `eclipse` (the default), or `native` for our own. A configuration that asks for
what ours does not do is opened with eclipse-zenoh all the same, and a line in the log says so.
"""

from __future__ import annotations

import json
import os

import zenoh

from goalwire.errors import TransportError
from goalwire.transport.reports import LOGGER
from goalwire.transport.zenoh.wire import Wire

VARIABLE = 'GOALWIRE_ZENOH'
NATIVE, ECLIPSE = 'native', 'eclipse'
DEFAULT = ECLIPSE


def open_wire(config: zenoh.Config) -> Wire:
    """Open a session. Raises TransportError or ForkedError."""
    chosen = os.environ.get(VARIABLE) or DEFAULT
    if chosen not in {NATIVE, ECLIPSE}:
        raise TransportError(f"{VARIABLE} is '{chosen}'; set it to {NATIVE} or {ECLIPSE}")
    wire = _open_native(config) if chosen == NATIVE else None
    if wire is None:
        from goalwire.transport.zenoh.eclipse import EclipseWire

        wire = EclipseWire(config)
    return wire


def _open_native(config: zenoh.Config) -> Wire | None:
    """Open a session of ours; None where the configuration asks for what ours does not do."""
    # Of the two kinds of session only the one that is opened is imported: either costs some 10 ms.
    from goalwire.transport.zenoh.native.configuration import BeyondOursError, native_settings
    from goalwire.transport.zenoh.native.wire import NativeWire

    try:
        settings = native_settings(json.loads(str(config)))
    except BeyondOursError as error:
        from goalwire.logging import get_logger

        get_logger(LOGGER).info(f'eclipse-zenoh is used: the configuration asks for {error}')
        return None
    return NativeWire(settings)
