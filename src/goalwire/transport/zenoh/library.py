"""eclipse-zenoh: imported by whoever imports this, which only its sessions and routers need.

They are started in the right process, with a configuration as it reads it, and fail in its own words.
"""

from __future__ import annotations

import json

import zenoh

from goalwire.errors import TransportError
from goalwire.transport.zenoh import threads
from goalwire.transport.zenoh.settings.values import Configuration
from goalwire.zenoh.io.endpoints import LOOPBACK, is_localhost_known

_LOCALHOST = '"tcp/localhost:'
"""The beginning of an address that zenoh looks up; if a certificate is checked, the name must stay."""


def reason(error: Exception) -> str:
    """Return zenoh's words without the place in its source."""
    return str(error).partition(' at /')[0].strip()


def open_zenoh(configuration: Configuration) -> zenoh.Session:
    """Open a session or a router.

    Raises zenoh.ZError if that fails, TransportError for a configuration that zenoh cannot use, and
    ForkedError in a child whose parent had opened one.
    """
    return threads.open_session(_loaded(configuration))


def _loaded(configuration: Configuration) -> zenoh.Config:
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
