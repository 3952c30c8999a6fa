"""How certificates are renewed over a network: the part of EST (RFC 7030) that renews, `simplereenroll`.

The client shows its present certificate in TLS, posts a request (PKCS #10) that its new key has signed, and
gets the new certificate with those of its authorities (PKCS #7). Both are sent as base64.
"""

from __future__ import annotations

from base64 import b64decode, b64encode
from binascii import Error as Base64Error

from cryptography import x509
from cryptography.hazmat.primitives import hashes, serialization
from cryptography.hazmat.primitives.asymmetric import ec
from cryptography.hazmat.primitives.serialization import pkcs7

from goalwire.errors import SecurityError

PORT = 7449
"""The default port of an authority, next to Zenoh's 7447 and 7448."""
PATH = '/.well-known/est/simplereenroll'
REQUEST_TYPE = 'application/pkcs10'
ANSWER_TYPE = 'application/pkcs7-mime; smime-type=certs-only'
AUTHORITY = 'authority'
"""The kind of the server's certificate. No identity of the site gets a certificate of that kind."""
LARGEST = 1 << 16
"""The largest size of a request or an answer, in bytes."""
CONNECTING_S = 3.0
"""How long, in s, connecting to the authority may take: a program that ends may have to wait that long."""
ANSWERING_S = 10.0
"""How long, in s, each side waits for the other."""


def write_request(subject: x509.Name, key: ec.EllipticCurvePrivateKey) -> bytes:
    """Return the request for a certificate of `subject` for a new key."""
    request = x509.CertificateSigningRequestBuilder().subject_name(subject).sign(key, hashes.SHA256())
    return b64encode(request.public_bytes(serialization.Encoding.DER))


def read_request(body: bytes, subject: x509.Name) -> ec.EllipticCurvePublicKey:
    """Return the key for which `subject` requests a certificate. Raises SecurityError."""
    try:
        request = x509.load_der_x509_csr(b64decode(body))
        is_valid = request.is_signature_valid
        key = request.public_key()
    except (ValueError, TypeError, Base64Error) as error:
        raise SecurityError(f'this is not a request for a certificate: {error}') from None
    if not is_valid:
        raise SecurityError('the request is not signed by its own key')
    if request.subject != subject:
        raise SecurityError('the request names somebody else than the certificate that was shown')
    if not isinstance(key, ec.EllipticCurvePublicKey) or not isinstance(key.curve, ec.SECP256R1):
        raise SecurityError('the request is for a key of another kind than P-256')
    return key


def write_answer(chain: tuple[x509.Certificate, ...]) -> bytes:
    """Return certificates as the text of an answer."""
    return b64encode(pkcs7.serialize_certificates(list(chain), serialization.Encoding.DER))


def read_answer(body: bytes, key: ec.EllipticCurvePublicKey) -> tuple[x509.Certificate, ...]:
    """Return the certificate of `key`, followed by those of its authorities. Raises SecurityError."""
    try:
        found = pkcs7.load_der_pkcs7_certificates(b64decode(body))
    except (ValueError, Base64Error) as error:
        raise SecurityError(f'the answer holds no certificates: {error}') from None
    own = [each for each in found if each.public_key() == key]
    if len(own) != 1:
        raise SecurityError('the answer holds no certificate for the key that was asked for')
    chain = own
    others = [each for each in found if each is not own[0]]
    while following := [each for each in others if each.subject == chain[-1].issuer and each not in chain]:
        chain.append(following[0])
    return tuple(chain)
