"""Renews the certificate of an identity, by the keystore's own authority if it has one, else by a remote one.

`authority.toml` has the address of the authority, which `goalwire secure authority` runs.
"""

from __future__ import annotations

import socket
import ssl
from collections.abc import Callable
from http import HTTPStatus
from http.client import HTTPSConnection
from time import time
from urllib.parse import urlsplit

from cryptography import x509

from goalwire.errors import SecurityError
from goalwire.security import certificates, enrollment, storage
from goalwire.security.environment import Chosen
from goalwire.security.keystore import Keystore

DUE = 2 / 3
"""The part of a certificate's life after which it is renewed."""


def end_of(chosen: Chosen) -> float:
    """Return when an identity's certificate ends, in s since the epoch. Raises SecurityError."""
    return Keystore(chosen.folder).identity(chosen.name).certificate.not_valid_after_utc.timestamp()


def renew_if_due(chosen: Chosen, keep: Callable[[ssl.SSLSocket], None]) -> float:
    """Renew an identity's certificate if it is due. Returns when the next renewal is due, in s since the
    epoch. `keep` gets the connection to the authority, which another thread may break off. Raises
    SecurityError, OSError or HTTPException if it is due and cannot be renewed.
    """
    keystore, name = Keystore(chosen.folder), chosen.name
    if time() < (due := _due(keystore, name)):
        return due
    # Other programs of this identity may renew the certificate at the same time: the second finds it renewed.
    with storage.hold_lock(keystore.path / 'identities' / f'.{name}.lock'):
        if time() >= _due(keystore, name):
            _renew(keystore, name, keep)
    return _due(keystore, name)


def _due(keystore: Keystore, name: str) -> float:
    certificate = keystore.identity(name).certificate
    life = certificates.life_of(certificate).total_seconds()
    return certificate.not_valid_after_utc.timestamp() - (1 - DUE) * life


def _renew(keystore: Keystore, name: str, keep: Callable[[ssl.SSLSocket], None]) -> None:
    before = keystore.identity(name)
    if (keystore.path / 'site.pem').exists():
        keystore.renew(name, certificates.life_of(before.certificate))
        return
    key = certificates.make_key()
    answer = _ask(keystore, name, enrollment.write_request(before.certificate.subject, key), keep)
    chain = enrollment.read_answer(answer, key.public_key())
    certificates.verify(chain, keystore.trust())
    if chain[0].subject != before.certificate.subject:
        raise SecurityError('the authority has answered with a certificate of somebody else')
    keystore.put(name, certificates.Pair(key, chain))


def _ask(keystore: Keystore, name: str, request: bytes, keep: Callable[[ssl.SSLSocket], None]) -> bytes:
    """Send a request to the authority and return the answer."""
    url = keystore.authority_url()
    if not url:
        raise SecurityError(f"'{keystore.path}' has neither site.pem nor authority.toml")
    context = ssl.SSLContext(ssl.PROTOCOL_TLS_CLIENT)
    context.minimum_version = ssl.TLSVersion.TLSv1_3
    context.check_hostname = False  # certificates name identities, not hosts; the kind is checked below
    context.load_verify_locations(keystore.trust_path)
    context.load_cert_chain(keystore.identity_path(name))
    address = urlsplit(url)
    plain = socket.create_connection((address.hostname, address.port), enrollment.CONNECTING_S)
    with context.wrap_socket(plain, do_handshake_on_connect=False) as tls:
        keep(tls)
        tls.settimeout(enrollment.ANSWERING_S)
        tls.do_handshake()
        shown = tls.getpeercert(binary_form=True)
        assert shown is not None  # TLS has verified the certificate
        if certificates.kind_of(x509.load_der_x509_certificate(shown)) != enrollment.AUTHORITY:
            raise SecurityError(f'{url} is not the authority of this site')
        connection = HTTPSConnection(address.hostname or '', address.port)
        connection.sock = tls
        connection.request('POST', enrollment.PATH, request, {'Content-Type': enrollment.REQUEST_TYPE})
        response = connection.getresponse()
        answer = response.read(enrollment.LARGEST)
        if response.status != HTTPStatus.OK:
            raise SecurityError(f'{url} refuses: {response.reason}')
        return answer
