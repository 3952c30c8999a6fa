"""The guard of the page: an ASGI application around it that lets only permitted requests pass.

A page on another site can make a browser send requests to this server with this site's cookies, and open web
sockets, to which the same-origin policy does not apply. If that site points its own host name at this machine
(DNS rebinding), its requests even look like requests of this site. So three rules hold: if nobody needs a
token, `Host` must be a name of this machine; `Origin` must be the requested address; if a token is needed, a
cookie must contain it. `entry` decides which tokens count.

The cookie is `SameSite=Strict`: a browser never sends it with a request that another site has begun, nor with
the redirects of such a request. So the answer to a link in a mail or a chat cannot be a redirect that sets
the cookie. The answer is `_ENTRANCE`, a page of this site that sets the cookie and then loads the requested
page.
"""

from __future__ import annotations

import hashlib
import re
from base64 import b64encode
from collections.abc import Awaitable, Callable, MutableMapping
from html import escape
from http.cookies import CookieError, SimpleCookie
from typing import Any, TypeAlias
from urllib.parse import parse_qsl

from goalwire.apps.console.entry import CERTIFICATE, PRINCIPAL, SIGN_OUT, Entry, Visitor
from goalwire.apps.console.settings import Settings
from goalwire.errors import SecurityError, peer_text
from goalwire.web_admission import host_name, is_loopback

Scope: TypeAlias = MutableMapping[str, Any]
Message: TypeAlias = MutableMapping[str, Any]
Receive: TypeAlias = Callable[[], Awaitable[Message]]
Send: TypeAlias = Callable[[Message], Awaitable[None]]
Application: TypeAlias = Callable[[Scope, Receive, Send], Awaitable[None]]

COOKIE = 'goalwire_console'
MOST_BYTES = 1 << 20
"""The most bytes of a request's body, and of a web socket's message."""

_POLICY = (
    "default-src 'self'; script-src 'self' 'unsafe-inline' 'unsafe-eval'; style-src 'self' 'unsafe-inline'; "
    "img-src 'self' data: blob:; font-src 'self' data:; connect-src {sources}; "
    "worker-src 'self' blob:; "
    "object-src 'none'; base-uri 'none'; form-action 'self'; frame-ancestors 'none'"
)
_HEADERS = [
    (b'x-content-type-options', b'nosniff'),
    (b'referrer-policy', b'no-referrer'),
    (b'cross-origin-opener-policy', b'same-origin'),
    (b'cross-origin-resource-policy', b'same-origin'),
]
_HOST_OF_A_POLICY = re.compile(r'[A-Za-z0-9.-]+(?::[0-9]+)?')
"""Hosts that a content security policy may name. It cannot name IPv6 addresses; `'self'` covers those."""

_GO_ON = (
    'const address = new URL(location.href);'
    "address.searchParams.delete('token');"
    'location.replace(address.href);'
)
_ENTRANCE = (
    '<!doctype html><html lang="en"><meta charset="utf-8"><title>goalwire console</title>'
    f'<script>{_GO_ON}</script><noscript>This page needs JavaScript.</noscript></html>\n'
).encode()
_ENTRANCE_POLICY = (
    "default-src 'none'; base-uri 'none'; form-action 'none'; frame-ancestors 'none'; "
    f"script-src 'sha256-{b64encode(hashlib.sha256(_GO_ON.encode()).digest()).decode()}'"
)


_SIGN_IN = """<!doctype html><html lang="en"><meta charset="utf-8"><title>Sign in · goalwire console</title>
<meta name="viewport" content="width=device-width">
<style>
body { font: 16px/1.5 system-ui, sans-serif; max-width: 26rem; margin: 12vh auto; padding: 0 1rem; }
input, button { font: inherit; padding: .5rem .7rem; width: 100%; box-sizing: border-box; margin-top: .6rem; }
p { color: #555; } .bad { color: #b3261e; }
@media (prefers-color-scheme: dark) { body { background: #121417; color: #e8e8e8; } p { color: #aaa; } }
</style>
<h1>goalwire console</h1>
<form method="get" action="/">
<label for="token">Your token</label>
<input id="token" name="token" type="password" autocomplete="current-password" autofocus required>
<button>Sign in</button>
</form>
<p class="bad" role="alert" data-why>{why}</p>
<p>A token is made with <code>goalwire secure token NAME</code>.</p></html>
"""
_SIGN_IN_POLICY = (
    "default-src 'none'; base-uri 'none'; form-action 'self'; frame-ancestors 'none'; "
    "style-src 'unsafe-inline'"
)


class TooLargeError(Exception):
    """A request's body is larger than MOST_BYTES: it is answered with 413."""


class Guard:
    """Wraps an application; refuses strangers, limits sizes, and adds the headers that bind a browser."""

    def __init__(
        self,
        application: Application,
        settings: Settings,
        entry: Entry,
        is_full: Callable[[], bool] = lambda: False,
        note: Callable[[str], object] = lambda _text: None,
    ) -> None:
        """`is_full` returns True if no more pages are allowed, because each page needs memory.

        `note` is called with texts about normal events, such as a browser that left before its answer.
        """
        self._application = application
        self._settings = settings
        self._entry = entry
        self._is_full = is_full
        self._note = note

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Serve one connection."""
        if scope['type'] == 'lifespan':
            await self._application(scope, receive, send)
            return
        headers = {
            name.decode('latin-1').lower(): value.decode('latin-1') for name, value in scope['headers']
        }
        reason = self._refusal(headers)
        if reason:
            await _refuse(scope, send, 403, reason)
            return
        in_address = _token_in_address(scope)
        try:
            visitor = self._entry.admit(_tokens(headers, in_address), scope.get('state', {}).get(CERTIFICATE))
        except SecurityError as error:
            await self._turn_away(scope, send, str(error))
            return
        if scope['path'] == SIGN_OUT:
            await _send_to_the_page(send, self._cookie('', '; Max-Age=0'))
        elif in_address is not None:
            await _send_entrance(send, self._cookie(visitor.token) if visitor.token else '')
        else:
            await self._admit(scope, headers, receive, send, visitor)

    async def _admit(
        self, scope: Scope, headers: dict[str, str], receive: Receive, send: Send, visitor: Visitor
    ) -> None:
        scope.setdefault('state', {})[PRINCIPAL] = visitor.principal
        if scope['type'] == 'http':
            await self._serve(scope, headers, receive, send)
        else:
            await self._application(scope, receive, send)

    async def _turn_away(self, scope: Scope, send: Send, reason: str) -> None:
        """Answer a browser that has shown no valid token; if visitors sign in, send a form for the token."""
        if scope['type'] != 'http' or not self._entry.has_names:
            await _refuse(scope, send, 403, reason)
            return
        page = _SIGN_IN.replace('{why}', escape(reason)).encode()
        headers = [
            (b'content-type', b'text/html; charset=utf-8'),
            (b'content-security-policy', _SIGN_IN_POLICY.encode()),
            (b'cache-control', b'no-store'),
            *_HEADERS,
        ]
        await send({'type': 'http.response.start', 'status': 401, 'headers': headers})
        await send({'type': 'http.response.body', 'body': page})

    def _refusal(self, headers: dict[str, str]) -> str:
        """Return the reason to refuse a request; '' if it is allowed."""
        host = headers.get('host', '')
        if self._entry.is_open and not is_loopback(host_name(host)):
            return 'this page is served to this machine alone, under the name localhost'
        origin = headers.get('origin')
        if origin is not None and origin.lower() != f'{self._settings.scheme}://{host}'.lower():
            return 'another site may not talk to this page'
        if headers.get('sec-fetch-site') == 'cross-site' and not _is_followed_link(headers):
            return 'another site may not talk to this page'
        return ''

    def _cookie(self, token: str, more: str = '') -> str:
        secure = '; Secure' if self._settings.tls_cert else ''
        return f'{COOKIE}={token}; HttpOnly; SameSite=Strict; Path=/{secure}{more}'

    def _headers(self, asked: dict[str, str]) -> list[tuple[bytes, bytes]]:
        """Return the headers that bind a browser to this origin, which the request's headers name."""
        host = asked.get('host', '')
        socket = 'wss' if self._settings.scheme == 'https' else 'ws'
        sources = "'self'" + (f' {socket}://{host}' if _HOST_OF_A_POLICY.fullmatch(host) else '')
        return [(b'content-security-policy', _POLICY.format(sources=sources).encode()), *_HEADERS]

    async def _serve(self, scope: Scope, headers: dict[str, str], receive: Receive, send: Send) -> None:
        length = headers.get('content-length', '0')
        if not length.isdecimal() or int(length) > MOST_BYTES:
            await _refuse(scope, send, 413, 'that is too large')
            return
        if scope['path'] == '/' and self._is_full():
            await _refuse(scope, send, 503, 'too many pages are open: close some, or try again in a minute')
            return
        received, has_left = 0, False

        async def limited() -> Message:
            nonlocal received, has_left
            message = await receive()
            has_left = has_left or message['type'] == 'http.disconnect'
            received += len(message.get('body', b''))
            if received > MOST_BYTES:
                raise TooLargeError
            return message

        begun = False

        async def with_headers(message: Message) -> None:
            nonlocal begun
            if message['type'] == 'http.response.start':
                begun = True
                message['headers'] = [*message.get('headers', ()), *self._headers(headers)]
            await send(message)

        try:
            await self._application(scope, limited, with_headers)
        except TooLargeError:
            if not begun:
                await _refuse(scope, send, 413, 'that is too large')
        except Exception as error:
            if not has_left or not _tells_that_it_left(error):
                raise
            self._note(f"a browser left before it had the answer to '{peer_text(scope['path'], 100)}'")


def _tells_that_it_left(error: Exception) -> bool:
    """Return True if Starlette raises this error when a browser leaves; one is a plain RuntimeError."""
    from starlette.requests import ClientDisconnect

    return isinstance(error, ClientDisconnect) or str(error) == 'No response returned.'


def _is_followed_link(headers: dict[str, str]) -> bool:
    """Return True if the browser loads the answer as a page in a tab, not as a picture, script or frame."""
    return headers.get('sec-fetch-mode') == 'navigate' and headers.get('sec-fetch-dest') == 'document'


def _tokens(headers: dict[str, str], in_address: str | None) -> tuple[str, ...]:
    """Return the tokens that a request shows: a new one in the address comes before that of the cookie."""
    authorization = headers.get('authorization', '').removeprefix('Bearer ')
    try:
        morsel = SimpleCookie(headers.get('cookie', '')).get(COOKIE)
    except CookieError:
        morsel = None
    return in_address or '', authorization, morsel.value if morsel else ''


def _token_in_address(scope: Scope) -> str | None:
    """Return the token in a page's address; None if it has none."""
    if scope['type'] != 'http' or scope['method'] != 'GET':
        return None
    query = scope.get('query_string', b'').decode('latin-1')
    return dict(parse_qsl(query, keep_blank_values=True)).get('token')


async def _send_entrance(send: Send, cookie: str) -> None:
    """Send the page that loads the same address without the token, so that history and `Referer` lack it."""
    headers = [
        (b'content-type', b'text/html; charset=utf-8'),
        (b'content-security-policy', _ENTRANCE_POLICY.encode()),
        (b'cache-control', b'no-store'),
        *([(b'set-cookie', cookie.encode('latin-1'))] if cookie else []),
        *_HEADERS,
    ]
    await send({'type': 'http.response.start', 'status': 200, 'headers': headers})
    await send({'type': 'http.response.body', 'body': _ENTRANCE})


async def _send_to_the_page(send: Send, cookie: str) -> None:
    """Redirect the browser to the page, and replace or delete its cookie."""
    headers = [
        (b'location', b'/'),
        (b'cache-control', b'no-store'),
        (b'set-cookie', cookie.encode('latin-1')),
        *_HEADERS,
    ]
    await send({'type': 'http.response.start', 'status': 303, 'headers': headers})
    await send({'type': 'http.response.body', 'body': b''})


async def _refuse(scope: Scope, send: Send, status: int, reason: str) -> None:
    if scope['type'] == 'websocket':
        # A web socket that is closed before it is accepted gets the status 403.
        await send({'type': 'websocket.close', 'code': 1008, 'reason': reason})
        return
    policy = (b'content-security-policy', b"default-src 'none'; frame-ancestors 'none'")
    headers = [(b'content-type', b'text/plain; charset=utf-8'), (b'connection', b'close'), policy, *_HEADERS]
    await send({'type': 'http.response.start', 'status': status, 'headers': headers})
    await send({'type': 'http.response.body', 'body': f'{reason}\n'.encode()})
