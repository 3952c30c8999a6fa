"""Opens listening sockets for the console and the bridges, and makes the errors about sockets and TLS files.

The errors name the options to change.
"""

from __future__ import annotations

import socket

from goalwire.errors import TransportError


def listen(host: str, port: int, *, takes_both: bool = False) -> socket.socket:
    """Listen at an address; with `takes_both` an IPv6 socket also accepts IPv4. Raises OSError,
    OverflowError.
    """
    family = socket.AF_INET6 if ':' in host else socket.AF_INET
    return socket.create_server((host, port), family=family, backlog=128, dualstack_ipv6=takes_both)


def cannot_listen(host: str, port: int, error: Exception) -> TransportError:
    """Return the error for an address at which `listen` failed."""
    reason = getattr(error, 'strerror', None) or error
    return TransportError(f'cannot listen on {host}:{port}: {reason}; choose another --port')


def unusable_tls_files(error: OSError) -> TransportError:
    """Return the error for a certificate or a key that cannot be used."""
    return TransportError(f'the TLS files cannot be used: {error}; give --tls-cert and --tls-key')
