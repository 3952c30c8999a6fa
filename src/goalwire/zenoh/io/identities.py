"""The other side's identity: its certificate, once TLS has verified it."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any, TypeAlias

from goalwire.errors import SecurityError
from goalwire.records import record
from goalwire.zenoh.protocol.guard import Guard


@record
class PeerCertificate:
    """The parts of a verified certificate that a session needs."""

    name: str
    """The certificate's common name (CN)."""
    kind: str
    """The certificate's organizational unit (OU)."""
    begins: float
    """The start of the certificate's validity, in s since the epoch."""
    ends: float


Identify: TypeAlias = Callable[[PeerCertificate], Guard | None]
"""Returns the guard of a link, or None to allow everything. Raises SecurityError to refuse the link."""


def read_peer_certificate(found: Mapping[str, Any] | None) -> PeerCertificate:
    """Read the other side's certificate in the form of `ssl`. Raises SecurityError if there is none."""
    import ssl  # imported here, since only sessions with TLS need it

    if not found:
        raise SecurityError('the other side shows no certificate')
    subject = [pair for part in found.get('subject', ()) for pair in part]

    def only(field: str) -> str:
        values = [value for name, value in subject if name == field]
        return values[0] if len(values) == 1 else ''

    return PeerCertificate(
        only('commonName'),
        only('organizationalUnitName'),
        ssl.cert_time_to_seconds(found['notBefore']),
        ssl.cert_time_to_seconds(found['notAfter']),
    )
