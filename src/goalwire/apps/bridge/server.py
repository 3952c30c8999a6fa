"""The web socket side of a bridge: who may connect, one session per client, and slow clients."""

from __future__ import annotations

import asyncio
import logging
import socket
import ssl
from collections.abc import Callable, Sequence
from contextlib import suppress
from http import HTTPStatus
from typing import Protocol, Self
from urllib.parse import parse_qsl, urlsplit

from websockets.asyncio.server import Server, ServerConnection, serve
from websockets.exceptions import ConnectionClosed
from websockets.frames import CloseCode
from websockets.http11 import Request, Response
from websockets.protocol import State
from websockets.typing import Subprotocol

import goalwire
from goalwire.apps.bridge.hub import Hub
from goalwire.apps.bridge.outbox import Frame, Outbox
from goalwire.apps.bridge.permissions import Permissions
from goalwire.apps.bridge.settings import Settings
from goalwire.errors import SecurityError, peer_text
from goalwire.listening import cannot_listen, listen, unusable_tls_files
from goalwire.records import replace
from goalwire.security.environment import choose_identity
from goalwire.security.sign_in.authorizer import Authorizer
from goalwire.security.sign_in.signed_in import SignedIn
from goalwire.web_admission import host_name, is_loopback, is_of_this_machine, is_same_token

_QUIET = logging.getLogger('goalwire.bridge.websockets')
_MOST_REASON = 100
"""Characters of the reason with which a client is disconnected; a web socket has room for 123 bytes."""
# Silence the package `websockets`, which logs tracebacks; this module logs the important errors itself.
_QUIET.addHandler(logging.NullHandler())
_QUIET.propagate = False


class Session(Protocol):
    """A protocol's handling of one client."""

    async def receive(self, frame: Frame) -> None:
        """Take a client's frame. Must not wait for the robot, because that would delay the next frame."""

    async def close(self) -> None:
        """End the calls and subscriptions of the client, which has disconnected."""


OpenSession = Callable[[Hub, Outbox, Permissions], Session]
LOOK_S = 1.0
"""Seconds between two checks of the rights of signed-in clients; Zenoh links are checked as often."""


async def serve_clients(
    node: goalwire.Node,
    settings: Settings,
    open_session: OpenSession,
    ready: Callable[[str], object],
    subprotocols: Sequence[str] = (),
) -> None:
    """Serve clients until cancelled; call `ready` with the address once clients can connect.

    Raises TransportError if the port is taken, or the TLS files cannot be read.
    """
    with _listen(settings) as listener:
        encryption = _encryption(settings)
        async with (
            Hub(node, settings) as hub,
            _Door(hub, open_session) as door,
            serve(
                door.attend,
                sock=listener,
                ssl=encryption,
                process_request=door.judge,
                subprotocols=[Subprotocol(each) for each in subprotocols] or None,
                max_size=settings.most_bytes,
                # Compression costs more than it saves, and a small frame could decompress to a large message
                compression=None,
                logger=_QUIET,
                server_header=None,
            ) as server,
        ):
            ready(settings.url(_port(server)))
            await server.wait_closed()


class _Door:
    """Admits or refuses clients, and runs the session of each.

    If the bridge has an identity (GOALWIRE_SECURITY), each client signs in under a name in the policy.
    """

    def __init__(self, hub: Hub, open_session: OpenSession) -> None:
        """Raises SecurityError if the identity that the environment names cannot be used."""
        self._hub = hub
        self._open_session = open_session
        self._count = 0
        chosen = choose_identity()
        domain = hub.node.context.get_domain_id()
        self._authorizer = None if chosen is None else Authorizer(chosen, domain)
        self._signed_in: dict[ServerConnection, SignedIn] = {}
        self._look: asyncio.Task[None] | None = None

    async def __aenter__(self) -> Self:
        if self._authorizer is not None:
            self._look = asyncio.get_running_loop().create_task(self._look_at_rights())
        return self

    async def __aexit__(self, *_error: object) -> None:
        if self._look is not None:
            self._look.cancel()
            with suppress(asyncio.CancelledError):
                await self._look
        if self._authorizer is not None:
            self._authorizer.close()

    async def _look_at_rights(self) -> None:
        """Disconnect clients whose tokens have become invalid, or whose rights have changed."""
        while True:
            await asyncio.sleep(LOOK_S)
            closing = []
            for connection, client in list(self._signed_in.items()):
                problem = client.problem()
                if problem or connection.state is State.CLOSED:
                    del self._signed_in[connection]
                    closing.append(connection.close(CloseCode.POLICY_VIOLATION, problem[:_MOST_REASON]))
            await asyncio.gather(*closing)

    def judge(self, connection: ServerConnection, request: Request) -> Response | None:
        """Return the response that refuses a request; None if the request is allowed."""
        try:
            reason = self._refusal(request)
            if not reason and self._authorizer is not None:
                principal = self._authorizer.find_principal(_token(request))
                self._signed_in[connection] = SignedIn(self._authorizer, principal)
        except SecurityError as error:
            reason = f'{error}: goalwire secure token NAME makes one'
        if reason:
            return connection.respond(HTTPStatus.FORBIDDEN, f'{reason}\n')
        if self._count >= self._hub.settings.most_clients:
            self._signed_in.pop(connection, None)
            return connection.respond(HTTPStatus.SERVICE_UNAVAILABLE, 'too many clients are connected\n')
        return None

    def _refusal(self, request: Request) -> str:
        settings = self._hub.settings
        headers = request.headers
        if self._authorizer is not None:
            return '' if _token(request) else 'a token is missing: ?token=…'
        if settings.token:
            is_right = is_same_token(_token(request), settings.token)
            return '' if is_right else 'the token is missing or wrong: ?token=…'
        if not all(is_loopback(host_name(host)) for host in headers.get_all('Host')):
            return 'this bridge serves this machine alone, under the name localhost'
        for origin in headers.get_all('Origin'):
            if origin not in settings.origins and not is_of_this_machine(origin):
                return f'pages of {peer_text(origin, 200)} may not connect: see the option --origin'
        return ''

    async def attend(self, connection: ServerConnection) -> None:
        """Serve one client until it disconnects."""
        self._count += 1
        log = self._hub.node.logger
        peer = peer_text(str(connection.remote_address[:2] if connection.remote_address else 'a client'), 80)
        outbox = Outbox(self._hub.settings.backlog, connection.transport.abort)
        client = self._signed_in.get(connection)
        if client is not None:
            client.note_done('connect', 'the bridge', f'signed in from {peer}')
        session = self._open_session(
            self._hub, outbox, replace(self._hub.settings.permissions, client=client)
        )
        sending = asyncio.get_running_loop().create_task(_send(outbox, connection))
        try:
            with suppress(ConnectionClosed):
                async for frame in connection:
                    await session.receive(frame)
        finally:
            self._count -= 1
            self._signed_in.pop(connection, None)
            sending.cancel()
            await session.close()
            for topic, count in outbox.dropped.most_common(10):
                log.warning(f"client {peer} read too slowly: it missed {count} messages of '{topic}'")


def _token(request: Request) -> str:
    """Return the token that a client shows, in its address or in a header."""
    query = dict(parse_qsl(urlsplit(request.path).query))
    return query.get('token') or ''.join(request.headers.get_all('Authorization')).removeprefix('Bearer ')


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
