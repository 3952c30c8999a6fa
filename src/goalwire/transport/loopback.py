"""The check of the loopback device, which is down in a new network namespace."""

from __future__ import annotations

import errno

ADVICE = (
    'the loopback device is down, so programs of this machine cannot reach each other: '
    'run ip link set lo up (as root, in the same network namespace)'
)
"""The error text if nothing at 127.0.0.1 answers, with advice."""

_DISCARD_PORT = 9


def is_loopback_down() -> bool:
    """Return whether 127.0.0.1 has no route. Sends nothing."""
    import socket  # imported here: needed only when nothing answers

    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as probe:
        return probe.connect_ex(('127.0.0.1', _DISCARD_PORT)) in {errno.ENETUNREACH, errno.EADDRNOTAVAIL}
