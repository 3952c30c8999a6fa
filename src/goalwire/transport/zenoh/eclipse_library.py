"""Opens sessions and routers of eclipse-zenoh. Importing this module imports eclipse-zenoh.

The module refuses forked processes, converts the configuration, and reports zenoh's own error texts.
"""

from __future__ import annotations

import json

import zenoh

from goalwire.errors import TransportError
from goalwire.transport.zenoh import threads
from goalwire.transport.zenoh.settings.values import Configuration
from goalwire.zenoh.io.endpoints import LOOPBACK, is_localhost_known

_LOCALHOST = '"tcp/localhost:'
"""The start of an address whose name zenoh would look up. With TLS the name must stay, to be compared."""


def reason(error: Exception) -> str:
    """Return zenoh's error text without the position in its source code."""
    return str(error).partition(' at /')[0].strip()


def open_zenoh(configuration: Configuration) -> zenoh.Session:
    """Open a session or a router.

    Raises zenoh.ZError if that fails, TransportError for a configuration that zenoh cannot use, and
    ForkedError in a child whose parent had opened one.
    """
    return threads.open_session(_load(configuration))


def _load(configuration: Configuration) -> zenoh.Config:
    text = json.dumps(configuration.values)
    if _LOCALHOST in text and not is_localhost_known():
        text = text.replace(_LOCALHOST, _LOCALHOST.replace('localhost', LOOPBACK))
    try:
        return zenoh.Config.from_json5(text)
    except zenoh.ZError as error:
        origin = configuration.origin or 'ZENOH_CONFIG_OVERRIDE asks for a configuration'
        raise TransportError(
            f'{origin}, which cannot be used: {reason(error)}; correct it, or unset the variable'
        ) from None
