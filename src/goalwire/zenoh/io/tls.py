"""TLS (`tls/HOST:PORT`): the same bytes inside OpenSSL's records, over sockets that never block.

OpenSSL works on memory here and never sees the socket. So all encrypted bytes wait in one place until the
socket takes them, and a message of a higher priority cannot cut into a half-encrypted one.
"""

from __future__ import annotations

import os
import socket
import ssl
from collections.abc import Callable, Mapping, Sequence
from contextlib import suppress
from pathlib import Path
from threading import RLock
from typing import TYPE_CHECKING, Any, TypeVar

from goalwire.concurrency.poller import OUT, Poller
from goalwire.concurrency.sigpipe import NO_SIGPIPE
from goalwire.errors import SecurityError, TransportError
from goalwire.zenoh.io.endpoints import TlsFiles
from goalwire.zenoh.io.identities import Identify, read_peer_certificate
from goalwire.zenoh.io.socket_link import JOINED_SIZE, SocketLink, SocketLinkOwner, join_first

if TYPE_CHECKING:
    from goalwire.zenoh.protocol.channels import Buffer
    from goalwire.zenoh.protocol.handshake import Handshake

T = TypeVar('T')


def client_context(files: TlsFiles) -> ssl.SSLContext:
    """Return the TLS context for outgoing connections.

    Raises TransportError for a file that cannot be used.
    """
    context = ssl.SSLContext(ssl.PROTOCOL_TLS_CLIENT)
    context.check_hostname = files.verify_name_on_connect
    _trust(context, files)
    if files.enable_mtls:
        _insist_on_tls_1_3(context)
        _show(context, files.connect_certificate, files.connect_private_key, 'connect')
    return context


def server_context(files: TlsFiles) -> ssl.SSLContext:
    """Return the TLS context for incoming connections.

    Raises TransportError for a file that cannot be used.
    """
    context = ssl.SSLContext(ssl.PROTOCOL_TLS_SERVER)
    _show(context, files.listen_certificate, files.listen_private_key, 'listen')
    if files.enable_mtls:
        context.verify_mode = ssl.CERT_REQUIRED
        context.num_tickets = 0  # no resumed sessions: each new link must show its certificate again
        _insist_on_tls_1_3(context)
        _trust(context, files)
    return context


def _insist_on_tls_1_3(context: ssl.SSLContext) -> None:
    """Require TLS 1.3: older versions send certificates in plain text, and can resume sessions."""
    context.minimum_version = ssl.TLSVersion.TLSv1_3


def _trust(context: ssl.SSLContext, files: TlsFiles) -> None:
    if not files.root_ca_certificate:
        context.load_default_certs()
        return
    try:
        context.load_verify_locations(files.root_ca_certificate)
    except OSError as error:
        raise TransportError(_unusable('root_ca_certificate', files.root_ca_certificate, error)) from None


def _show(context: ssl.SSLContext, certificate: str, key: str, use: str) -> None:
    """Load the certificate that is shown to the other side. A key with a password is refused."""
    for name, path in ((f'{use}_certificate', certificate), (f'{use}_private_key', key)):
        if not path:
            raise TransportError(f'TLS needs transport/link/tls/{name}: set it to the path of a PEM file')
        try:
            with Path(path).open('rb'):
                pass
        except OSError as error:
            raise TransportError(_unusable(name, path, error)) from None
    try:
        context.load_cert_chain(certificate, key, password=lambda: b'')
    except OSError as error:
        raise TransportError(_unusable(f'{use}_certificate', f"{certificate}' with '{key}", error)) from None


def _unusable(name: str, path: str, error: OSError) -> str:
    return f"transport/link/tls/{name}: '{path}' cannot be used: {explain(error)}"


_HERE = 'transport/link/tls'
_ADVICE = {
    'mismatch': f'it must name the host that is dialled, or set {_HERE}/verify_name_on_connect to false here',
    'issuer': f'{_HERE}/root_ca_certificate must hold the authority that signed it',
    'self-signed': f'{_HERE}/root_ca_certificate must hold the authority that signed it',
    'certificate has expired': "renew the other side's certificate, or set this machine's clock",
    'not yet valid': "set this machine's clock, or renew the other side's certificate",
    'alert certificate expired': "the other side refuses this side's certificate: renew it, or set its clock",
    'alert unknown ca': "the root_ca_certificate there must hold the authority of this side's certificate",
    'alert bad certificate': "it is refused there: does this side's certificate name the host dialled?",
    'certificate required': f'set {_HERE}/enable_mtls, connect_certificate and connect_private_key here',
    'did not return a certificate': 'set enable_mtls and connect_certificate there, or turn it off here',
    'wrong version number': 'the other side speaks no TLS: both addresses must begin with tls/',
    'http request': 'the other side speaks no TLS: this port is for Zenoh',
}
"""The advice for an error, by a part of OpenSSL's text."""


def explain(error: OSError) -> str:
    """Return the text of an error of TLS or of a file, with advice if there is any."""
    if isinstance(error, ssl.SSLCertVerificationError):
        text = f'the certificate is not accepted: {error.verify_message.rstrip(".")}'
    elif isinstance(error, ssl.SSLError) and error.reason:
        text = error.reason.lower().replace('_', ' ')
    else:
        return error.strerror or str(error)
    advice = next((advice for part, advice in _ADVICE.items() if part in text), '')
    return f'{text}; {advice}' if advice else text


class TlsStream:
    """A connected socket with TLS on it. Its methods read and write as a socket's do.

    Any thread may use it: OpenSSL does one thing at a time.
    """

    def __init__(self, sock: socket.socket, context: ssl.SSLContext, server_name: str | None) -> None:
        """`server_name` is the host that a client dialled; None for a server."""
        self._socket = sock
        self._incoming, self._outgoing = ssl.MemoryBIO(), ssl.MemoryBIO()
        self._tls = context.wrap_bio(
            self._incoming, self._outgoing, server_side=server_name is None, server_hostname=server_name
        )
        self._unsent = memoryview(b'')
        self._is_sending = False
        """True while bytes go to the socket: then a signal's handler must not send other bytes in between."""
        self._is_over = False
        # Reentrant: a signal's handler may publish while its thread holds this lock.
        self._lock = RLock()

    @property
    def has_unsent(self) -> bool:
        """True while encrypted bytes wait for the socket."""
        return len(self._unsent) > 0 or self._outgoing.pending > 0

    def shake_hands(self) -> bool:
        """Go on with the handshake; True once it is done. Raises OSError (ssl.SSLError) if it fails."""
        with self._lock:
            self._fill()
            try:
                self._tls.do_handshake()
            except ssl.SSLWantReadError:
                return False
            finally:
                self.flush()
            return True

    def peer_certificate(self) -> Mapping[str, Any] | None:
        """Return the other side's certificate in the form of `ssl`; empty or None if it shows none."""
        return self._tls.getpeercert()

    def _fill(self) -> None:
        """Hand the received bytes to OpenSSL."""
        with suppress(BlockingIOError, InterruptedError):
            data = self._socket.recv(JOINED_SIZE)
            if data:
                self._incoming.write(data)
            else:
                self._incoming.write_eof()
                self._is_over = True

    def recv(self, size: int) -> bytes:
        """Return all bytes that have come, b'' at the stream's end. Raises BlockingIOError if none came."""
        with self._lock:
            self._fill()
            parts: list[bytes] = []
            with suppress(ssl.SSLWantReadError, ssl.SSLZeroReturnError, ssl.SSLEOFError):
                while part := self._tls.read(size):
                    parts.append(part)
                self._is_over = True
            if self._outgoing.pending:
                self.flush()
        if not parts and not self._is_over:
            raise BlockingIOError
        return parts[0] if len(parts) == 1 else b''.join(parts)

    def send(self, data: Buffer, _flags: int = 0) -> int:
        """Encrypt and send; return how many bytes were taken.

        Raises BlockingIOError while earlier bytes wait.
        """
        with self._lock:
            if self._is_sending:
                raise BlockingIOError
            self._is_sending = True
            try:
                return self._send(memoryview(data))
            finally:
                self._is_sending = False

    def _send(self, data: memoryview) -> int:
        """Encrypt piece by piece while the socket takes all. So at most one piece waits encrypted."""
        if not self._flush():
            raise BlockingIOError
        taken = 0
        while taken < len(data) and not self._unsent:
            end = min(len(data), taken + JOINED_SIZE)
            while taken < end:
                taken += self._tls.write(data[taken:end])
            self._flush()
        return taken

    def sendmsg(self, buffers: Sequence[Buffer], _ancillary: tuple[()] = (), _flags: int = 0) -> int:
        """Send the first of several buffers, small ones joined."""
        return self.send(join_first(buffers))

    def flush(self) -> bool:
        """Send the encrypted bytes; False if the socket is full, or another call is sending."""
        with self._lock:
            if self._is_sending:
                return False
            self._is_sending = True
            try:
                return self._flush()
            finally:
                self._is_sending = False

    def _flush(self) -> bool:
        while self._unsent or self._outgoing.pending:
            if not self._unsent:
                self._unsent = memoryview(self._outgoing.read())
            try:
                # one bytecode stores the result, as in SocketLink.write: no signal comes between
                (sent,) = map(self._socket.send, (self._unsent,), (NO_SIGPIPE,))
                self._unsent = self._unsent[sent:]
            except (BlockingIOError, InterruptedError):
                return False
        return True

    def end(self) -> None:
        """Tell the other side that the stream ends, if the socket takes that message at once."""
        with self._lock, suppress(OSError, ValueError):
            with suppress(ssl.SSLWantReadError):
                self._tls.unwrap()
            self.flush()


class TlsSocketLink(SocketLink):
    """A connected socket with TLS on it, and its link, which starts after the handshake of TLS."""

    def __init__(
        self,
        owner: SocketLinkOwner,
        sock: socket.socket,
        handshake: Handshake,
        poller: Poller,
        *,
        tls: TlsStream,
        identify: Identify | None,
    ) -> None:
        """`tls` is the stream on `sock`; `identify` identifies the other side by its certificate."""
        super().__init__(owner, sock, handshake, poller)
        self._tls = tls
        self._identify = identify
        self._is_secure = False
        self._recv = self._decrypt
        self._send = tls.send
        self._sendmsg = tls.sendmsg

    def _start_link(self) -> None:
        self._shake_hands()

    def _shake_hands(self) -> None:
        """Go on with the handshake of TLS. After it, identify the other side, then start the link."""
        try:
            self._is_secure = self._tls.shake_hands()
        except ssl.SSLEOFError:
            self.end('the other side has hung up')
            return
        except OSError as error:
            self.end(f'TLS: {explain(error)}', is_fault=True)
            return
        if self._is_secure:
            if not self._know_other_side():
                return
            self.link.start()
        self._watch_unsent()

    def _know_other_side(self) -> bool:
        """Identify the other side; close the link and return False if it is refused."""
        if self._identify is not None:
            try:
                self.link.guard = self._identify(read_peer_certificate(self._tls.peer_certificate()))
            except SecurityError as error:
                self._is_secure = False
                self.end(str(error), is_fault=True)
                return False
        return True

    def _decrypt(self, size: int) -> bytes:
        try:
            return self._tls.recv(size)
        except ssl.SSLError as error:  # in TLS 1.3, the other side's refusal of our certificate arrives here
            self.end(f'TLS: {explain(error)}', is_fault=True)
            raise BlockingIOError from None

    def _watch_unsent(self) -> None:
        """Have the rest of the encrypted bytes sent once there is room."""
        if self._tls.has_unsent:
            self.request_flush()

    def _has_unsent(self) -> bool:
        return super()._has_unsent() or self._tls.has_unsent

    def write(self, data: Buffer) -> int:
        return self._encrypt(super().write, data)

    def write_many(self, buffers: list[Buffer]) -> int:
        return self._encrypt(super().write_many, buffers)

    def _encrypt(self, write: Callable[[T], int], data: T) -> int:
        try:
            taken = write(data)
            self._watch_unsent()
        except BaseException:  # A signal's handler has raised: how many bytes OpenSSL has taken is unknown.
            self._poller.call(lambda: self.end('its writer was interrupted'))
            raise
        return taken

    def on_ready(self, events: int) -> None:
        if events & OUT:
            try:
                self._tls.flush()
            except OSError as error:
                self.end(f'the connection broke: {explain(error)}')
                return
        if not self._is_secure:
            self._shake_hands()
        if self._is_secure:
            super().on_ready(events)
            with self.outgoing.lock:
                if not self._has_ended:
                    self._watch_unsent()  # reading may have made OpenSSL write an answer

    def _say_goodbye(self) -> None:
        self._tls.end()


def _look_at(path: str) -> tuple[int, int]:
    try:
        found = os.stat(path)  # noqa: PTH116 - each new link looks
    except OSError:
        return 0, 0
    return found.st_ino, found.st_mtime_ns


class Tls:
    """The TLS of one session. Each method raises TransportError for a file that cannot be used."""

    def __init__(self, files: TlsFiles, identify: Identify | None = None) -> None:
        self._files = files
        self._identify = identify
        self._client: ssl.SSLContext | None = None
        self._server: ssl.SSLContext | None = None
        self._seen = self._look()

    def refresh(self) -> None:
        """Read the files again if one has changed. If that fails, the old certificates stay in use."""
        seen = self._look()
        if seen == self._seen:
            return
        self._seen = seen
        client = None if self._client is None else client_context(self._files)
        server = None if self._server is None else server_context(self._files)
        self._client, self._server = client, server

    def _look(self) -> tuple[tuple[int, int], ...]:
        """Return a value that changes when one of the files is replaced or written to."""
        files = self._files
        names = {
            files.root_ca_certificate,
            files.listen_certificate,
            files.listen_private_key,
            files.connect_certificate,
            files.connect_private_key,
        }
        return tuple(map(_look_at, sorted(filter(None, names))))

    def check_listening(self) -> ssl.SSLContext:
        """Return the TLS context for incoming connections."""
        if self._server is None:
            self._server = server_context(self._files)
        return self._server

    def check_dialling(self) -> ssl.SSLContext:
        """Return the TLS context for outgoing connections."""
        if self._client is None:
            self._client = client_context(self._files)
        return self._client

    def make_inbound(
        self, owner: SocketLinkOwner, sock: socket.socket, handshake: Handshake, poller: Poller
    ) -> SocketLink:
        """Return the link of a connection that another side has opened."""
        stream = TlsStream(sock, self.check_listening(), None)
        return TlsSocketLink(owner, sock, handshake, poller, tls=stream, identify=self._identify)

    def make_outbound(
        self, owner: SocketLinkOwner, sock: socket.socket, handshake: Handshake, poller: Poller, host: str
    ) -> SocketLink:
        """Return the link of a connection that was opened to `host`."""
        stream = TlsStream(sock, self.check_dialling(), host)
        return TlsSocketLink(owner, sock, handshake, poller, tls=stream, identify=self._identify)
