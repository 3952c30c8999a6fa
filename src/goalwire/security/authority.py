"""The server of `goalwire secure authority`: renews the certificate of a client that shows a valid one."""

from __future__ import annotations

import ssl
import tempfile
from collections.abc import Callable
from contextlib import suppress
from datetime import datetime, timedelta
from http import HTTPStatus
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from pathlib import Path
from socket import AF_INET6, socket
from threading import BoundedSemaphore
from typing import Any

from cryptography import x509

from goalwire.errors import SecurityError
from goalwire.security import KINDS, certificates, enrollment, revocation, storage
from goalwire.security.keystore import Keystore
from goalwire.security.policy_file import load_policy

MOST_AT_ONCE = 32
"""How many connections are served at one time. Further ones are closed, and their clients try again."""
_OWN_LIFE = timedelta(days=2)
"""The lifetime of the server's own certificate. The server makes a new certificate after half of that."""


class AuthorityServer(ThreadingHTTPServer):
    """Listens, and renews certificates. `serve_forever` runs it; `shutdown`, from another thread, ends it."""

    daemon_threads = True
    allow_reuse_address = True

    def __init__(self, keystore: Keystore, port: int, tell: Callable[[str], None]) -> None:
        """`tell` gets a line for each certificate that was renewed or refused.

        Raises OSError for a port that is taken, and SecurityError for a keystore without a site's authority.
        """
        self.keystore = keystore
        self.tell = tell
        self._room = BoundedSemaphore(MOST_AT_ONCE)
        self._context, self._renew_at = self._make_context()
        with suppress(OSError), socket(AF_INET6) as probe:
            probe.bind(('::', 0))
            self.address_family = AF_INET6
        super().__init__(('', port), _Handler)

    def _make_context(self) -> tuple[ssl.SSLContext, datetime]:
        """Return a TLS context with a new certificate of the server's own, and the time at which the next is
        due.
        """
        now = certificates.now()
        life = (now - certificates.CLOCK_SKEW, now + _OWN_LIFE)
        own = certificates.make_identity(self.keystore.site(), 'authority', enrollment.AUTHORITY, life)
        context = ssl.SSLContext(ssl.PROTOCOL_TLS_SERVER)
        context.minimum_version = ssl.TLSVersion.TLSv1_3
        context.num_tickets = 0
        context.verify_mode = ssl.CERT_REQUIRED
        context.load_verify_locations(self.keystore.trust_path)
        with tempfile.TemporaryDirectory() as folder:  # ssl takes keys from files only
            path = Path(folder, 'own.pem')
            storage.create(path, own.pem())
            context.load_cert_chain(path)
        return context, now + _OWN_LIFE / 2

    def process_request(self, request: Any, client_address: Any) -> None:
        """Serve a connection on a thread of its own, if there is room for it."""
        if self._room.acquire(blocking=False):
            super().process_request(request, client_address)
        else:
            self.shutdown_request(request)

    def process_request_thread(self, request: Any, client_address: Any) -> None:
        """Shake hands, and serve one request."""
        try:
            super().process_request_thread(request, client_address)
        finally:
            self._room.release()

    def finish_request(self, request: Any, client_address: Any) -> None:
        """Shake hands on this connection's own thread, so that no other client waits for a slow handshake."""
        if certificates.now() > self._renew_at:
            self._context, self._renew_at = self._make_context()
        request.settimeout(enrollment.ANSWERING_S)
        with self._context.wrap_socket(request, server_side=True) as tls:
            super().finish_request(tls, client_address)

    def handle_error(self, request: Any, client_address: Any) -> None:
        """Log nothing of broken connections or failed handshakes: strangers can cause any number of them."""

    def renew(self, shown: x509.Certificate, body: bytes) -> bytes:
        """Return the answer to a request of the identity that shows a certificate. Raises SecurityError."""
        name, kind = certificates.common_name(shown), certificates.kind_of(shown)
        if kind not in KINDS:
            raise SecurityError(f"'{name}' is not an identity of a kind that is renewed")
        if revocation.is_revoked(self.keystore.list_revoked(), name, shown.not_valid_before_utc):
            raise SecurityError(f"the certificate of '{name}' is revoked")
        if not load_policy(self.keystore.policy_path).knows(name):
            raise SecurityError(f"policy.toml does not name '{name}'")
        key = enrollment.read_request(body, shown.subject)
        chain = self.keystore.certify(name, kind, key, certificates.life_of(shown))
        self.tell(
            f'{name} has a certificate that is valid until {chain[0].not_valid_after_utc:%Y-%m-%d %H:%M} UTC'
        )
        return enrollment.write_answer(chain)


class _Handler(BaseHTTPRequestHandler):
    """Answers one request."""

    server: AuthorityServer
    connection: ssl.SSLSocket

    def do_POST(self) -> None:
        size = self.headers.get('Content-Length', '')
        if self.path != enrollment.PATH:
            self.send_error(HTTPStatus.NOT_FOUND)
            return
        if not size.isascii() or not size.isdigit() or not 0 < int(size[:9]) <= enrollment.LARGEST:
            self.send_error(HTTPStatus.REQUEST_ENTITY_TOO_LARGE)
            return
        shown = self.connection.getpeercert(binary_form=True)
        assert shown is not None  # TLS requires a certificate
        certificate = x509.load_der_x509_certificate(shown)
        try:
            answer = self.server.renew(certificate, self.rfile.read(int(size)))
        except SecurityError as error:
            self.server.tell(f'{certificates.common_name(certificate)} was refused: {error}')
            self.send_error(HTTPStatus.FORBIDDEN, str(error))
            return
        self.send_response(HTTPStatus.OK)
        self.send_header('Content-Type', enrollment.ANSWER_TYPE)
        self.send_header('Content-Transfer-Encoding', 'base64')
        self.send_header('Content-Length', str(len(answer)))
        self.end_headers()
        self.wfile.write(answer)

    def log_message(self, *_arguments: object) -> None:
        """Log nothing: `renew` tells what happened."""
