"""Serves the page from the node's own loop, until it is cancelled."""

from __future__ import annotations

import asyncio
import errno
import logging
import os
import re
import socket
import ssl
import sys
import traceback
from collections.abc import Callable, Iterator
from contextlib import closing, contextmanager

import h11
import uvicorn
from fastapi import FastAPI
from uvicorn.protocols.http.h11_impl import H11Protocol

import goalwire
from goalwire.apps.console.addresses import is_every_interface
from goalwire.apps.console.entry import CERTIFICATE, SharedToken, SignIn
from goalwire.apps.console.guard import MOST_BYTES, Guard
from goalwire.apps.console.page import recording_page
from goalwire.apps.console.page.shell import install
from goalwire.apps.console.page.site import is_full
from goalwire.apps.console.settings import Settings
from goalwire.apps.console.state.recording import Recording
from goalwire.apps.console.state.session import Session
from goalwire.errors import TransportError, peer_text
from goalwire.execution.asyncio.waiting import in_thread
from goalwire.listening import cannot_listen, listen, unusable_tls_files
from goalwire.logging import RcutilsLogger, get_logger
from goalwire.security.environment import Chosen, choose_identity
from goalwire.security.sign_in.authorizer import Authorizer

_GRACE_S = 2
"""Seconds that browsers have to disconnect when the console ends."""


HEAD_S = 10.0
"""Seconds within which the head of a request must arrive."""
MOST_HEAD_BYTES = 64 << 10
"""The most bytes of a request's head: its first line, its headers, and the empty line."""
_END_OF_HEAD = re.compile(rb'\n\r?\n')
_FAREWELL_S = 1.0
"""Seconds that a client has to read the refusal of its request before its connection is closed."""
_CERTIFICATE = re.compile(r'-----BEGIN CERTIFICATE-----.*?-----END CERTIFICATE-----', re.DOTALL)
_LOGGERS = ('uvicorn', 'nicegui', 'engineio', 'socketio', 'asyncio')


class _OneLine(logging.Handler):
    """Passes the web server's log records to the node's logger, each as one line.

    Any client that reaches the port can cause log records, so they have no tracebacks. With
    GOALWIRE_FULL_TRACEBACKS=1 they have.
    """

    def __init__(self, logger: RcutilsLogger) -> None:
        super().__init__(logging.WARNING)
        self._logger = logger

    def emit(self, record: logging.LogRecord) -> None:
        """Log a record."""
        text = record.getMessage()
        error = record.exc_info[1] if record.exc_info else None
        if error is not None:
            frames = traceback.extract_tb(error.__traceback__)
            place = f' at {frames[-1].filename}:{frames[-1].lineno}' if frames else ''
            text = f'{text.splitlines()[0] if text else ""}: {error!r}{place}'
            if os.environ.get('GOALWIRE_FULL_TRACEBACKS') == '1':
                traceback.print_exception(error)
        self._logger.warning(f'web server: {peer_text(text, 500)}', throttle_duration_sec=0.2)


@contextmanager
def _log_by(own: RcutilsLogger) -> Iterator[None]:
    handler = _OneLine(own)
    loggers = [logging.getLogger(name) for name in _LOGGERS]
    for name in ('engineio.server', 'socketio.server'):
        logging.getLogger(name).handlers.clear()  # instead of uvicorn's own handlers, which print tracebacks
    for logger in loggers:
        logger.addHandler(handler)
        logger.propagate = False
    try:
        yield
    finally:
        for logger in loggers:
            logger.removeHandler(handler)
            logger.propagate = True


class _Connection(h11.Connection):
    """An h11 connection that refuses all heads that are too large; h11 itself accepts complete ones."""

    def __init__(self) -> None:
        super().__init__(h11.SERVER, MOST_HEAD_BYTES)

    def next_event(self) -> type[h11.NEED_DATA | h11.PAUSED] | h11.Event:
        """Return the next event of the parser. Raises RemoteProtocolError."""
        if self.their_state is h11.IDLE:
            received, _ = self.trailing_data
            end = _END_OF_HEAD.search(received)
            if (len(received) if end is None else end.end()) > MOST_HEAD_BYTES:
                raise h11.RemoteProtocolError('the head is too large', error_status_hint=431)
        return super().next_event()


class _Http(H11Protocol):
    """Refuses heads that are too large, and closes connections whose head does not come in time.

    uvicorn itself would wait for ever. This class extends uvicorn's protocol with h11, because the one with
    httptools accepts heads of any size. Requests for web sockets arrive here first, too.
    """

    _timer: asyncio.TimerHandle | None = None
    _is_refused = False

    def connection_made(self, transport: asyncio.Transport) -> None:  # type: ignore[override]
        super().connection_made(transport)
        self.conn = _Connection()
        tls = transport.get_extra_info('ssl_object')
        if tls is not None:
            self.app_state = {**self.app_state, CERTIFICATE: tls.getpeercert()}
        self._await_head()

    def data_received(self, data: bytes) -> None:
        if self._is_refused:
            return  # Closing with unread data would reset the connection and lose the answer.
        super().data_received(data)
        self._await_head()

    def connection_lost(self, exc: Exception | None) -> None:
        self._set_timer(None)
        super().connection_lost(exc)

    def send_400_response(self, msg: str) -> None:
        """Answer a request that h11 refuses; uvicorn calls this while it handles h11's error."""
        error = sys.exception()
        if not isinstance(error, h11.RemoteProtocolError) or error.error_status_hint != 431:
            super().send_400_response(msg)
            return
        self._is_refused = True
        text = f'a head of more than {MOST_HEAD_BYTES} bytes\n'.encode()
        self.transport.write(
            b'HTTP/1.1 431 Request Header Fields Too Large\r\nContent-Type: text/plain; charset=utf-8\r\n'
            b'Connection: close\r\nContent-Length: %d\r\n\r\n%b' % (len(text), text)
        )
        if self.transport.can_write_eof():
            self.transport.write_eof()
        self._set_timer(self.loop.call_later(_FAREWELL_S, self.transport.close))

    def _await_head(self) -> None:
        if self._is_refused:
            return
        if self.conn.their_state is not h11.IDLE:
            self._set_timer(None)
        elif self._timer is None:
            self._set_timer(self.loop.call_later(HEAD_S, self.transport.close))

    def _set_timer(self, timer: asyncio.TimerHandle | None) -> None:
        if self._timer is not None:
            self._timer.cancel()
        self._timer = timer


class _Server(uvicorn.Server):
    """Says when it has started, and leaves signals to the command that runs it."""

    def __init__(self, config: uvicorn.Config) -> None:
        super().__init__(config)
        self.taking = asyncio.Event()

    async def startup(self, sockets: list[socket.socket] | None = None) -> None:
        await super().startup(sockets)
        self.taking.set()

    @contextmanager
    def capture_signals(self) -> Iterator[None]:
        yield


async def serve(node: goalwire.Node, settings: Settings, ready: Callable[[list[str]], object]) -> None:
    """Serve the page; call `ready` with its addresses (see `Settings.urls`) once it can be opened.

    Only once in a process, because the page's routes are global. Raises TransportError if the port is taken
    or the TLS files cannot be read.
    """
    with (
        _authorizer(node.context.get_domain_id()) as authorizer,
        _listen(settings) as listener,
        _log_by(node.logger),
    ):
        async with Session(node, settings, authorizer) as session:
            application = _application()
            install(application, session)
            await _serve(application, listener, settings, authorizer, node.logger, ready)


async def serve_recording(path: str, settings: Settings, ready: Callable[[list[str]], object]) -> None:
    """Serve the page of a bag, without a node, as `serve` does. Also raises BagError and OSError."""
    logger = get_logger('goalwire_console')
    recording = await in_thread(lambda: Recording(path))
    goals = await in_thread(recording.read_goals)
    with _authorizer(0) as authorizer, _listen(settings) as listener, _log_by(logger):
        application = _application()
        with recording_page.install(application, recording, goals):
            await _serve(application, listener, settings, authorizer, logger, ready)


@contextmanager
def _authorizer(domain: int) -> Iterator[Authorizer | None]:
    """Open the keystore of this program's identity for the block; None if it has no identity.

    Raises SecurityError if the environment names one that cannot be used.
    """
    chosen = choose_identity()
    if chosen is None:
        yield None
        return
    with closing(Authorizer(chosen, domain)) as authorizer:
        yield authorizer


def _application() -> FastAPI:
    return FastAPI(docs_url=None, redoc_url=None, openapi_url=None)


async def _serve(
    application: FastAPI,
    listener: socket.socket,
    settings: Settings,
    authorizer: Authorizer | None,
    logger: RcutilsLogger,
    ready: Callable[[list[str]], object],
) -> None:
    server = _Server(_config(application, settings, authorizer, logger))
    serving = asyncio.get_running_loop().create_task(server.serve(sockets=[listener]))
    try:
        taking = asyncio.get_running_loop().create_task(server.taking.wait())
        await asyncio.wait([taking, serving], return_when=asyncio.FIRST_COMPLETED)
        if not taking.done():
            taking.cancel()
            raise TransportError('the page cannot be served: see the lines above')
        ready(settings.urls(listener.getsockname()[1]))
        await asyncio.shield(serving)
    finally:
        server.should_exit = True
        await asyncio.wait([serving])


def _listen(settings: Settings) -> socket.socket:
    host = settings.host
    takes_both = ':' in host and is_every_interface(host) and socket.has_dualstack_ipv6()
    try:
        try:
            return listen(host, settings.port, takes_both=takes_both)
        except OSError as error:
            if error.errno != errno.EADDRINUSE or not settings.takes_any_port:
                raise
            return listen(host, 0, takes_both=takes_both)
    except (OSError, OverflowError) as error:
        raise cannot_listen(host, settings.port, error) from None


def _config(
    application: FastAPI, settings: Settings, authorizer: Authorizer | None, logger: RcutilsLogger
) -> uvicorn.Config:
    entry = SharedToken(settings.token) if authorizer is None else SignIn(authorizer)
    config = uvicorn.Config(
        Guard(application, settings, entry, is_full, logger.debug),  # type: ignore[arg-type, unused-ignore] # the same thing, typed alike
        log_config=None,
        log_level='warning',
        access_log=False,
        server_header=False,
        ws_max_size=MOST_BYTES,
        # Compression costs more than it saves, and a small frame could decompress to a large message
        ws_per_message_deflate=False,
        ws_ping_interval=20,
        http=_Http,
        limit_concurrency=400,
        timeout_graceful_shutdown=_GRACE_S,
        proxy_headers=False,
        ssl_certfile=settings.tls_cert or None,
        ssl_keyfile=settings.tls_key or None,
        ssl_keyfile_password='-',  # noqa: S106 - a key with a password is refused; OpenSSL would ask for it
    )
    try:
        config.load()
    except OSError as error:
        raise unusable_tls_files(error) from None
    if authorizer is not None and config.ssl is not None:
        _ask_for_certificates(config.ssl, authorizer.identity)
    return config


def _ask_for_certificates(context: ssl.SSLContext, identity: Chosen) -> None:
    """Ask browsers for a certificate of the keystore, with which people sign in instead of with a token."""
    context.verify_mode = ssl.CERT_OPTIONAL
    context.load_verify_locations(identity.folder / 'trust.pem')
    # A browser may send its certificate without that of the site's authority, which the identity's file has.
    for certificate in _CERTIFICATE.findall(identity.identity_path.read_text())[1:]:
        context.load_verify_locations(cadata=certificate)
