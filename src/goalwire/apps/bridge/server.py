"""The web socket side of a bridge: who may connect, one session per client, and slow clients."""

from __future__ import annotations

import asyncio
import logging
import socket
import ssl
from collections.abc import Callable, Sequence
from contextlib import suppress
from http import HTTPStatus
from typing import Protocol
from urllib.parse import parse_qsl, urlsplit

from websockets.asyncio.server import Server, ServerConnection, serve
from websockets.exceptions import ConnectionClosed
from websockets.http11 import Request, Response
from websockets.typing import Subprotocol

import goalwire
from goalwire.admission import host_name, is_loopback, is_of_this_machine, is_same_token
from goalwire.apps.bridge.hub import Hub
from goalwire.apps.bridge.outbox import Frame, Outbox
from goalwire.apps.bridge.settings import Settings
from goalwire.errors import peer_text
from goalwire.listening import cannot_listen, listen, unusable_tls_files

_QUIET = logging.getLogger('goalwire.bridge.websockets')
# Silence the library, which logs tracebacks; this module logs the important errors itself.
_QUIET.addHandler(logging.NullHandler())
_QUIET.propagate = False


class Session(Protocol):
    """A protocol's handling of one client."""

    async def receive(self, frame: Frame) -> None:
        """Take a client's frame. Must not wait for the robot, because that would delay the next frame."""

    async def close(self) -> None:
        """End the calls and subscriptions of the client, which has disconnected."""


OpenSession = Callable[[Hub, Outbox], Session]


async def serve_clients(
    node: goalwire.Node,
    settings: Settings,
    open_session: OpenSession,
    ready: Callable[[str], object],
    subprotocols: Sequence[str] = (),
) -> None:
    """Serve clients until this is cancelled; call `ready` with the address once clients can connect.

    Raises TransportError if the port is taken, or the TLS files cannot be read.
    """
    with _listen(settings) as listener:
        encryption = _encryption(settings)
        async with Hub(node, settings) as hub:
            door = _Door(hub, open_session)
            async with serve(
                door.attend,
                sock=listener,
                ssl=encryption,
                process_request=door.judge,
                subprotocols=[Subprotocol(each) for each in subprotocols] or None,
                max_size=settings.most_bytes,
                # Compression costs more than it saves, and a small frame could become a large message
                compression=None,
                logger=_QUIET,
                server_header=None,
            ) as server:
                ready(settings.url(_port(server)))
                await server.wait_closed()


class _Door:
    """Admits or refuses clients, and runs the session of each."""

    def __init__(self, hub: Hub, open_session: OpenSession) -> None:
        self._hub = hub
        self._open_session = open_session
        self._count = 0

    def judge(self, connection: ServerConnection, request: Request) -> Response | None:
        """Return the response that refuses a request; None if the request is allowed."""
        reason = self._refusal(request)
        if reason:
            return connection.respond(HTTPStatus.FORBIDDEN, f'{reason}\n')
        if self._count >= self._hub.settings.most_clients:
            return connection.respond(HTTPStatus.SERVICE_UNAVAILABLE, 'too many clients are connected\n')
        return None

    def _refusal(self, request: Request) -> str:
        settings = self._hub.settings
        headers = request.headers
        if settings.token:
            query = dict(parse_qsl(urlsplit(request.path).query))
            shown = query.get('token') or ''.join(headers.get_all('Authorization')).removeprefix('Bearer ')
            return '' if is_same_token(shown, settings.token) else 'the token is missing or wrong: ?token=…'
        if not all(is_loopback(host_name(host)) for host in headers.get_all('Host')):
            return 'this bridge serves this machine alone, under the name localhost'
        for origin in headers.get_all('Origin'):
            if origin not in settings.origins and not is_of_this_machine(origin):
                return f'pages of {peer_text(origin, 200)} may not connect: see the option --origin'
        return ''

    async def attend(self, connection: ServerConnection) -> None:
        """Serve one client until its end."""
        self._count += 1
        log = self._hub.node.logger
        peer = peer_text(str(connection.remote_address[:2] if connection.remote_address else 'a client'), 80)
        outbox = Outbox(self._hub.settings.backlog, connection.transport.abort)
        session = self._open_session(self._hub, outbox)
        sending = asyncio.get_running_loop().create_task(_send(outbox, connection))
        try:
            with suppress(ConnectionClosed):
                async for frame in connection:
                    await session.receive(frame)
        finally:
            self._count -= 1
            sending.cancel()
            await session.close()
            for topic, count in outbox.dropped.most_common(10):
                log.warning(f"client {peer} read too slowly: it missed {count} messages of '{topic}'")


async def _send(outbox: Outbox, connection: ServerConnection) -> None:
    with suppress(ConnectionClosed):
        await outbox.send_all(connection)


def _port(server: Server) -> int:
    port: int = next(iter(server.sockets)).getsockname()[1]
    return port


def _listen(settings: Settings) -> socket.socket:
    try:
        return listen(settings.host, settings.port)
    except (OSError, OverflowError) as error:
        raise cannot_listen(settings.host, settings.port, error) from None


def _encryption(settings: Settings) -> ssl.SSLContext | None:
    if not settings.tls_cert:
        return None
    context = ssl.create_default_context(ssl.Purpose.CLIENT_AUTH)
    try:
        context.load_cert_chain(settings.tls_cert, settings.tls_key, password='-')  # noqa: S106 - refused, not asked for
    except OSError as error:
        raise unusable_tls_files(error) from None
    return context
