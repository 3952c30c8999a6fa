"""eclipse-zenoh: imported by whoever imports this, which only its sessions and routers need.

They are started in the right process, with a configuration as it reads it, and fail in its own words.
"""

from __future__ import annotations

import json

import zenoh

from goalwire.errors import TransportError
from goalwire.transport.zenoh import threads
from goalwire.transport.zenoh.settings.config import Configuration

def reason(error: Exception) -> str:
    """Return zenoh's words without the place in its source."""
    return str(error).partition(' at /')[0].strip()


def open_zenoh(configuration: Configuration) -> zenoh.Session:
    """Open a session or a router.

    Raises zenoh.ZError where that fails, TransportError for a configuration that zenoh cannot use, and
    ForkedError in a child whose parent had opened one.
    """
    return threads.open_session(_loaded(configuration))


def _loaded(configuration: Configuration) -> zenoh.Config:
    try:
        return zenoh.Config.from_json5(json.dumps(configuration.values))
    except zenoh.ZError as error:
        origin = configuration.origin or 'ZENOH_CONFIG_OVERRIDE asks for a configuration'
        raise TransportError(
            f'{origin}, which cannot be used: {reason(error)}; correct it, or unset the variable'
        ) from None
