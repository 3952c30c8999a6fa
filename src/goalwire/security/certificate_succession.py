"""Shows a renewed certificate over a link that was opened with the old one, so that the link stays open.

TLS shows certificates when a link begins, and the links of a robot last longer than its certificates. So a
session that has renewed its certificate sends it over each link. The new key signs the ids of both sessions,
so that no other session can use this message, or be its receiver. RFC 9261 has the same idea as a part of
TLS, which no library here offers.
"""

from __future__ import annotations

import json
from base64 import b64decode, b64encode

from cryptography import x509
from cryptography.exceptions import InvalidSignature
from cryptography.hazmat.primitives import hashes
from cryptography.hazmat.primitives.asymmetric import ec

from goalwire.errors import SecurityError
from goalwire.security import certificates
from goalwire.security.certificates import Pair

LARGEST = 1 << 16
"""The largest size of a message, in bytes; a longer message is cut off, and cannot be read."""
_ALGORITHM = ec.ECDSA(hashes.SHA256())


def _signed_text(sender: str, receiver: str) -> bytes:
    return f'goalwire: the session {sender} has this certificate now, said to {receiver}'.encode()


def show(pair: Pair, sender: str, receiver: str) -> bytes:
    """Return the message by which the session `sender` shows its certificate to the session `receiver`."""
    signature = pair.key.sign(_signed_text(sender, receiver), _ALGORITHM)
    message = {
        'session': sender,
        'certificates': b''.join(map(certificates.pem_of, pair.chain)).decode(),
        'signature': b64encode(signature).decode(),
    }
    return json.dumps(message).encode()


def read_shown(message: bytes, receiver: str, trusted: x509.Certificate) -> tuple[str, x509.Certificate]:
    """Return the session that shows a certificate, and the certificate. Raises SecurityError."""
    try:
        found = json.loads(message[:LARGEST])
        sender = str(found['session'])
        chain = tuple(x509.load_pem_x509_certificates(str(found['certificates']).encode()))
        signature = b64decode(found['signature'])
        key = chain[0].public_key()
    except (ValueError, TypeError, KeyError, IndexError, RecursionError) as error:
        raise SecurityError(f'the message shows no certificate: {error}') from None
    certificates.verify(chain, trusted)
    if not isinstance(key, ec.EllipticCurvePublicKey):
        raise SecurityError('the certificate is for a key of another kind than P-256')
    try:
        key.verify(signature, _signed_text(sender, receiver), _ALGORITHM)
    except InvalidSignature:
        raise SecurityError('the certificate is shown by somebody who has not its key') from None
    return sender, chain[0]
