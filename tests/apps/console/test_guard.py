"""The console's guard, which decides who is let in: alone, and in the whole server on a real socket."""

from __future__ import annotations

import asyncio
import base64
import os
import re
import signal
import socket
import ssl
from importlib.metadata import version
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest
from helpers.console import CONSOLE, Stage
from helpers.patience import PATIENCE
from helpers.processes import Program

from goalwire.apps.console.addresses import addresses_on_networks
from goalwire.apps.console.entry import SharedToken
from goalwire.apps.console.guard import COOKIE, MOST_BYTES, Guard
from goalwire.apps.console.settings import Settings
from goalwire.errors import NotAllowedError
from goalwire.web_admission import is_loopback, new_token

LOCAL = {'host': 'localhost:8420'}
TOKEN = 'a-token'
EMBEDDED = {'sec-fetch-site': 'cross-site', 'sec-fetch-mode': 'navigate', 'sec-fetch-dest': 'iframe'}


async def application(scope: Any, receive: Any, send: Any) -> None:
    if scope['type'] == 'websocket':
        await send({'type': 'websocket.accept'})
        return
    while (await receive()).get('more_body'):
        pass
    await send({'type': 'http.response.start', 'status': 200, 'headers': []})
    await send({'type': 'http.response.body', 'body': b'the page'})


def ask(settings: Settings, headers: dict[str, str], **changes: Any) -> list[dict[str, Any]]:
    """Return what a guard answers to one request."""
    chunks = changes.pop('chunks', [b''])
    is_full = changes.pop('is_full', lambda: False)
    scope = {
        'type': 'http',
        'method': 'GET',
        'path': '/',
        'query_string': b'',
        'headers': [(name.encode(), value.encode()) for name, value in headers.items()],
        **changes,
    }
    sent: list[dict[str, Any]] = []
    bodies = [
        {'type': 'http.request', 'body': chunk, 'more_body': at + 1 < len(chunks)}
        for at, chunk in enumerate(chunks)
    ]

    async def receive() -> dict[str, Any]:
        return bodies.pop(0)

    async def send(message: Any) -> None:
        sent.append(dict(message))

    asyncio.run(Guard(application, settings, SharedToken(settings.token), is_full)(scope, receive, send))
    return sent


def entrance(settings: Settings, headers: dict[str, str], query: str) -> tuple[dict[str, str], str]:
    """Return headers and text of the page that takes the token out of the address."""
    [first, body] = ask(settings, headers, query_string=query.encode())
    assert first['status'] == 200
    assert body['body'] != b'the page'
    return {name.decode(): value.decode() for name, value in first['headers']}, body['body'].decode()


def status(sent: list[dict[str, Any]]) -> int | str:
    first = sent[0]
    told: int | str = first['status'] if 'status' in first else first['type']
    return told


@pytest.mark.parametrize('host', ['localhost:8420', '127.0.0.1:8420', '[::1]:8420', 'localhost'])
def test_this_machine_is_let_in(host: str) -> None:
    assert status(ask(Settings(), {'host': host, 'origin': f'http://{host}'})) == 200


@pytest.mark.parametrize(
    'headers',
    [
        {},
        {'host': 'evil.example'},
        {'host': 'localhost.evil.example:8420'},
        {'host': '192.168.0.7:8420'},
        {'host': 'localhost:8420@evil.example'},
        {**LOCAL, 'origin': 'http://evil.example'},
        {**LOCAL, 'origin': 'http://localhost:9999'},
        {**LOCAL, 'origin': 'https://localhost:8420'},
        {**LOCAL, 'origin': 'null'},
        {**LOCAL, 'sec-fetch-site': 'cross-site', 'sec-fetch-mode': 'no-cors'},
        {**LOCAL, **EMBEDDED},
    ],
)
@pytest.mark.parametrize('kind', ['http', 'websocket'])
def test_strangers_are_not(headers: dict[str, str], kind: str) -> None:
    answer = status(ask(Settings(), headers, type=kind))
    assert answer == (403 if kind == 'http' else 'websocket.close')


def test_the_token_becomes_a_cookie() -> None:
    settings = Settings(host='0.0.0.0', token=TOKEN)
    headers = {'host': 'robot.local:8420'}
    assert status(ask(settings, headers)) == 403
    assert status(ask(settings, headers, query_string=b'token=wrong')) == 403
    assert status(ask(settings, headers, type='websocket', query_string=f'token={TOKEN}'.encode())) != 200
    given, page = entrance(settings, headers, f'view=topics&token={TOKEN}')
    assert given['set-cookie'] == f'{COOKIE}={TOKEN}; HttpOnly; SameSite=Strict; Path=/'
    assert (given['referrer-policy'], given['cache-control']) == ('no-referrer', 'no-store')
    assert TOKEN not in page
    assert status(ask(settings, {**headers, 'cookie': f'x=1; {COOKIE}={TOKEN}'})) == 200
    assert status(ask(settings, {**headers, 'authorization': f'Bearer {TOKEN}'})) == 200
    assert status(ask(settings, {**headers, 'cookie': f'{COOKIE}=wrong'})) == 403
    crossed = {**headers, 'cookie': f'{COOKIE}={TOKEN}', 'origin': 'http://evil.example'}
    assert status(ask(settings, crossed, type='websocket')) == 'websocket.close'


@pytest.mark.parametrize('query', [f'token={TOKEN}', 'token=of-yesterday', 'view=topics&token=', '%74oken=x'])
@pytest.mark.parametrize('token', [TOKEN, ''])
def test_no_page_is_served_at_an_address_with_a_token(token: str, query: str) -> None:
    settings = Settings(token=token)
    given, page = entrance(settings, {**LOCAL, 'cookie': f'{COOKIE}={TOKEN}'}, query)
    assert "searchParams.delete('token')" in page
    assert ('set-cookie' in given) == bool(token)


@pytest.mark.parametrize('headers', [{'origin': 'http://evil.example'}, EMBEDDED])
def test_another_site_gets_no_entrance_but_by_a_link(headers: dict[str, str]) -> None:
    settings = Settings(host='0.0.0.0', token=TOKEN)
    asked = {'host': 'robot.local:8420', **headers}
    assert status(ask(settings, asked, query_string=f'token={TOKEN}'.encode())) == 403


def test_bodies_are_bounded_whether_they_say_their_size_or_not() -> None:
    assert status(ask(Settings(), {**LOCAL, 'content-length': str(MOST_BYTES + 1)})) == 413
    assert status(ask(Settings(), {**LOCAL, 'content-length': 'x'})) == 413
    assert status(ask(Settings(), LOCAL, chunks=[b'x' * MOST_BYTES, b'x'])) == 413
    assert status(ask(Settings(), LOCAL, chunks=[b'x' * MOST_BYTES])) == 200


def test_a_link_on_another_site_may_be_followed() -> None:
    followed = {'sec-fetch-site': 'cross-site', 'sec-fetch-mode': 'navigate', 'sec-fetch-dest': 'document'}
    assert status(ask(Settings(), {**LOCAL, **followed})) == 200


def test_no_more_pages_are_made_when_there_are_too_many() -> None:
    assert status(ask(Settings(), LOCAL, is_full=lambda: True)) == 503
    assert status(ask(Settings(), LOCAL, is_full=lambda: True, path='/console/style.css')) == 200


def test_browsers_are_bound_by_headers() -> None:
    given = {name.decode(): value.decode() for name, value in ask(Settings(), LOCAL)[0]['headers']}
    assert "frame-ancestors 'none'" in given['content-security-policy']
    assert "default-src 'self'" in given['content-security-policy']
    assert "connect-src 'self' ws://localhost:8420;" in given['content-security-policy']
    assert given['x-content-type-options'] == 'nosniff'
    assert given['referrer-policy'] == 'no-referrer'


@pytest.mark.parametrize(
    ('host', 'scheme', 'sources'),
    [
        ('robot.local:8420', 'http', "'self' ws://robot.local:8420"),
        ('192.168.0.7', 'https', "'self' wss://192.168.0.7"),
        ('[fd00::1]:8420', 'http', "'self'"),
        ('x; script-src *', 'http', "'self'"),
        ('*', 'http', "'self'"),
    ],
)
def test_web_sockets_go_to_the_pages_own_address_alone(host: str, scheme: str, sources: str) -> None:
    settings = Settings(host='0.0.0.0', token=TOKEN, tls_cert='c' if scheme == 'https' else '')
    headers = {'host': host, 'authorization': f'Bearer {TOKEN}'}
    given = {name.decode(): value.decode() for name, value in ask(settings, headers)[0]['headers']}
    assert f'; connect-src {sources}; worker-src' in given['content-security-policy']


# -- what may be sent ----------------------------------------------------------------------------------------


def test_the_allow_list_and_read_only() -> None:
    arm = Settings(allow=('/arm/*', '/lamp'))
    assert [arm.may_send(name) for name in ('/arm/move', '/arm/a/b', '/lamp', '/lamps', '/leg')] == [
        True,
        True,
        True,
        False,
        False,
    ]
    assert Settings().may_send('/anything')
    with pytest.raises(NotAllowedError, match='read-only'):
        Settings(read_only=True, allow=('/arm/*',)).check_may_send('/arm/move')


def test_addresses() -> None:
    assert Settings(port=0).urls(81) == ['http://localhost:81/']
    assert Settings(host='::1').urls(81) == ['http://[::1]:81/']
    assert Settings(host='robot', token='t', tls_cert='c').urls(81) == ['https://robot:81/?token=t']
    assert Settings(host='fd00::1').urls(81) == ['http://[fd00::1]:81/']
    assert [is_loopback(host) for host in ('127.9.9.9', '::1', '0.0.0.0', 'robot')] == [
        True,
        True,
        False,
        False,
    ]
    assert len({new_token() for _ in range(100)}) == 100


@pytest.mark.parametrize(
    ('host', 'hosts'),
    [
        ('0.0.0.0', ['localhost', '192.168.0.7', '169.254.3.4', '10.0.0.2']),
        (
            '::',
            ['localhost', '192.168.0.7', '[fd00::7]', '169.254.3.4', '10.0.0.2', '[2001:db8::1]'],
        ),
    ],
)
def test_all_interfaces_have_the_addresses_by_which_others_reach_them(
    monkeypatch: pytest.MonkeyPatch, host: str, hosts: list[str]
) -> None:
    ifaddr = pytest.importorskip('ifaddr')
    if host == '::' and not socket.has_dualstack_ipv6():
        pytest.skip('there is no IPv6 here')
    interfaces = [
        ['127.0.0.1', ('::1', 0, 0)],
        ['192.168.0.7', ('fd00::7', 0, 0), ('fe80::7', 0, 2)],
        ['169.254.3.4', '10.0.0.2', '192.168.0.7', ('2001:db8::1', 0, 0)],
    ]
    adapters = [SimpleNamespace(ips=[SimpleNamespace(ip=ip) for ip in each]) for each in interfaces]
    monkeypatch.setattr(ifaddr, 'get_adapters', lambda: adapters)
    found = Settings(host=host, token='t').urls(8420)
    assert found == [f'http://{each}:8420/?token=t' for each in hosts]


# -- the server ----------------------------------------------------------------------------------------------


def exchange(port: int, request: bytes, secure: ssl.SSLContext | None = None) -> bytes:
    """Send bytes, and return all that comes back until the server closes."""
    with socket.create_connection(('127.0.0.1', port), timeout=PATIENCE) as plain:
        link = plain if secure is None else secure.wrap_socket(plain, server_hostname='localhost')
        with link:
            answer = b''
            try:
                link.sendall(request)
                while chunk := link.recv(65536):
                    answer += chunk
            except ConnectionError:
                pass  # it closes while we write
            return answer


def get(port: int, path: str, **headers: str) -> bytes:
    lines = [f'GET {path} HTTP/1.1', f'Host: {headers.pop("host", f"localhost:{port}")}', 'Connection: close']
    lines += [f'{name.replace("_", "-")}: {value}' for name, value in headers.items()]
    return ('\r\n'.join(lines) + '\r\n\r\n').encode()


def upgrade(port: int, **headers: str) -> bytes:
    key = base64.b64encode(os.urandom(16)).decode()
    path = '/_nicegui_ws/socket.io/?EIO=4&transport=websocket'
    return (
        f'GET {path} HTTP/1.1\r\nHost: localhost:{port}\r\nConnection: Upgrade\r\nUpgrade: websocket\r\n'
        f'Sec-WebSocket-Version: 13\r\nSec-WebSocket-Key: {key}\r\n'
        + ''.join(f'{name}: {value}\r\n' for name, value in headers.items())
        + '\r\n'
    ).encode()


@pytest.mark.parametrize('has_left', [True, False])
def test_a_browser_that_leaves_before_its_answer_is_noted_and_no_failure(has_left: bool) -> None:
    base = pytest.importorskip('starlette.middleware.base')
    events = ['http.request', 'http.disconnect'] if has_left else ['http.request']
    noted: list[str] = []

    async def silent(_scope: Any, receive: Any, _send: Any) -> None:
        for _ in range(len(events)):
            await receive()

    async def pass_on(request: Any, call_next: Any) -> Any:
        return await call_next(request)

    async def receive() -> dict[str, Any]:
        return {'type': events.pop(0), 'body': b'', 'more_body': has_left}

    async def send(_message: Any) -> None:
        raise AssertionError('nobody is there to be answered')

    headers = [(b'host', b'localhost:8420')]
    scope = {'type': 'http', 'method': 'GET', 'path': '/file', 'query_string': b'', 'headers': headers}
    guard = Guard(base.BaseHTTPMiddleware(silent, pass_on), Settings(), SharedToken(''), note=noted.append)
    if has_left:
        asyncio.run(guard(scope, receive, send))
    else:
        with pytest.raises(RuntimeError, match='No response'):
            asyncio.run(guard(scope, receive, send))
    assert noted == (["a browser left before it had the answer to '/file'"] if has_left else [])


def port_of(url: str) -> int:
    found = re.search(r':(\d+)/', url)
    assert found is not None
    return int(found[1])


def frame(opcode: int, payload: bytes, *, more: bool = False) -> bytes:
    """Make a masked web-socket frame, as clients send them; `more`: of a message that goes on."""
    size = (
        bytes([128 | len(payload)]) if len(payload) < 126 else bytes([255]) + len(payload).to_bytes(8, 'big')
    )
    return bytes([opcode if more else 128 | opcode]) + size + bytes(4) + payload


def closes(port: int, sent: bytes) -> bool:
    """Open a web socket, send bytes, and return whether the server then closes it."""
    with socket.create_connection(('127.0.0.1', port), timeout=PATIENCE) as link:
        link.sendall(upgrade(port, Origin=f'http://localhost:{port}'))
        answer = b''
        while b'\r\n\r\n' not in answer:
            answer += link.recv(65536)
        assert answer.startswith(b'HTTP/1.1 101 ')
        try:
            link.sendall(sent)
            while link.recv(65536):
                pass
        except TimeoutError:
            return False
        except ConnectionError:
            return True
        return True


def resident(pid: int) -> int:
    """Return how many bytes of memory a process has held at most."""
    found = re.search(r'VmHWM:\s+(\d+) kB', Path(f'/proc/{pid}/status').read_text(encoding='utf-8'))
    assert found is not None
    return int(found[1]) << 10


def padded(request: bytes, size: int) -> bytes:
    """Return a request whose head has that many bytes, by a header of its own."""
    return request[:-2] + b'X: ' + b'x' * (size - len(request) - 5) + b'\r\n\r\n'


@pytest.mark.slow
def test_a_head_of_more_than_64_kib_is_refused_however_it_comes(stage: Stage) -> None:
    console, url = stage.console()
    port = port_of(url)
    most = 64 << 10
    page = get(port, '/console/style.css')
    assert exchange(port, padded(page, most)).startswith(b'HTTP/1.1 200 ')
    assert exchange(port, padded(page, most + 1)).startswith(b'HTTP/1.1 431 ')
    line = page.replace(b'.css', b'.css?' + b'x' * most)
    assert exchange(port, line).startswith(b'HTTP/1.1 431 ')
    many = page[:-2] + b''.join(b'X-%d: y\r\n' % number for number in range(8000)) + b'\r\n'
    assert exchange(port, many).startswith(b'HTTP/1.1 431 ')
    # A web socket's, one that has no end yet, and one behind a request that is answered.
    opening = padded(upgrade(port, Origin=f'http://localhost:{port}'), most + 1)
    assert exchange(port, opening).startswith(b'HTTP/1.1 431 ')
    assert exchange(port, padded(page, 2 * most)[:-4]).startswith(b'HTTP/1.1 431 ')
    both = exchange(port, page.replace(b'close', b'keep-alive') + padded(page, most + 1))
    assert re.findall(rb'HTTP/1.1 (\d+) ', both) == [b'200', b'431']
    console.send_signal(signal.SIGTERM)
    assert console.wait() == 143
    assert 'Traceback' not in console.output


@pytest.mark.slow
def test_strangers_at_the_door(stage: Stage) -> None:
    console, url = stage.console(waits={'server.HEAD_S': 0.5})
    port = port_of(url)
    assert b' 200 OK' in exchange(port, get(port, '/'))
    assert b' 403 ' in exchange(port, get(port, '/', host='evil.example'))
    assert b' 403 ' in exchange(port, get(port, '/', origin='http://evil.example'))
    assert b' 403 ' in exchange(port, upgrade(port, Origin='http://evil.example'))
    for path in (
        '/_nicegui/../../../../../../etc/passwd',
        '/console/%2e%2e/%2e%2e/%2e%2e/etc/passwd',
        '/console/mesh/../../../etc/passwd',
        '/console/mesh/%2fetc%2fpasswd',
        '/../../etc/passwd',
        *(
            f'/_nicegui/{version("nicegui")}/{place}/%2e%2e/%2e%2e/%2e%2e/%2e%2e/%2e%2e/%2e%2e/etc/passwd'
            for place in ('static', 'libraries', 'components', 'esm/nicegui-scene', 'resources/x')
        ),
    ):
        answer = exchange(port, get(port, path))
        assert b' 404 ' in answer or b' 400 ' in answer or b' 403 ' in answer, path
        assert b'root:' not in answer
    large = exchange(
        port, f'POST / HTTP/1.1\r\nHost: localhost\r\nContent-Length: {100 << 20}\r\n\r\n'.encode()
    )
    assert b' 413 ' in large
    # A head of 100 MB, and one that never ends.
    before = resident(console.pid)
    assert b' 200 ' not in exchange(port, b'GET / HTTP/1.1\r\nX: ' + b'x' * (100 << 20))
    assert resident(console.pid) - before < 50 << 20
    assert exchange(port, b'GET / HTTP/1.1\r\nHost: local') == b''
    assert exchange(port, get(port, '/console/style.css').replace(b'close', b'keep-alive') + b'GET /').count(
        b' 200 OK'
    )
    # A body that never comes; what is served nowhere; a socket by requests.
    assert b' 405 ' in exchange(
        port, f'POST / HTTP/1.1\r\nHost: localhost:{port}\r\nContent-Length: 9\r\n\r\n'.encode()
    )
    for path in ('/docs', '/openapi.json', '/_nicegui/client/x/upload/1', '/missing'):
        missing = exchange(port, get(port, path))
        assert b' 404 ' in missing, path
        assert missing.endswith(b'there is no such page\n')
    assert b' 400 ' in exchange(port, get(port, '/_nicegui_ws/socket.io/?EIO=4&transport=polling'))
    assert b' 400 ' in exchange(port, b'\x00\x01 nonsense\r\n\r\n')
    for bad in (
        b'\x8f\x80\0\0\0\0',  # a reserved kind of frame
        b'\x81\x05hello',  # a frame without a mask
        frame(1, b'\xff\xfe\xff'),  # text that is not UTF-8
        bytes([129, 255])
        + (100 << 20).to_bytes(8, 'big')
        + bytes(4)
        + bytes(1 << 16),  # 100 MB are announced
        frame(1, b'x' * (1 << 19), more=True) + 9 * frame(0, b'x' * (1 << 19), more=True),  # and in pieces
        b'\xc1' + frame(1, b'xx')[1:],  # compressed, which was not agreed on
    ):
        assert closes(port, bad), bad[:10]
    good_bye = frame(8, b'\x03\xe8')
    for text in (
        b'42["event", 7]',
        b'42[',
        b'42["event",{"client_id":[]}]',
        b'45-["x"]',
        b'4' + b'[' * 50_000,
    ):
        assert closes(port, frame(1, b'40') + frame(1, text) + good_bye), text[:20]
    assert b' 200 OK' in exchange(port, get(port, '/'))
    console.send_signal(signal.SIGTERM)
    assert console.wait() == 143
    assert 'Traceback' not in console.output


@pytest.mark.slow
def test_beyond_this_machine_a_token_is_needed_and_tls_is_spoken(stage: Stage, tmp_path: Path) -> None:
    trustme = pytest.importorskip('trustme')
    authority = trustme.CA()
    certificate = authority.issue_cert('localhost')
    key, chain = tmp_path / 'key.pem', tmp_path / 'cert.pem'
    certificate.private_key_pem.write_to_path(str(key))
    certificate.cert_chain_pems[0].write_to_path(str(chain))
    console, url = stage.console('--host', '0.0.0.0', '--tls-cert', str(chain), '--tls-key', str(key))
    found = re.fullmatch(r'https://localhost:(\d+)/\?token=([\w-]{20,})', url)
    assert found is not None
    port, token = int(found[1]), found[2]
    trusting = ssl.create_default_context()
    authority.configure_trust(trusting)
    assert b' 403 ' in exchange(port, get(port, '/'), trusting)
    assert exchange(port, get(port, '/')) == b''  # unencrypted
    assert b' 403 ' in exchange(port, get(port, '/?token=x'), trusting)
    given = exchange(port, get(port, f'/?token={token}'), trusting)
    assert b' 200 OK' in given
    assert b'; HttpOnly; SameSite=Strict; Path=/; Secure\r\n' in given
    assert b' 403 ' in exchange(port, upgrade(port, Origin=f'https://localhost:{port}'), trusting)
    assert b' 200 OK' in exchange(port, get(port, '/', cookie=f'{COOKIE}={token}'), trusting)
    console.send_signal(signal.SIGINT)
    assert console.wait() == 130


@pytest.mark.slow
@pytest.mark.parametrize(('host', 'loopbacks'), [('0.0.0.0', ['127.0.0.1']), ('::', ['127.0.0.1', '::1'])])
def test_every_address_that_is_printed_has_the_token_and_leads_to_the_page(
    stage: Stage, host: str, loopbacks: list[str]
) -> None:
    if host == '::' and not socket.has_dualstack_ipv6():
        pytest.skip('there is no IPv6 here')
    found = addresses_on_networks(host)
    console = stage.program(CONSOLE, 'console', '--no-open', '--port', '0', '--token', TOKEN, '--host', host)
    port = int(console.expect(r'^the console is at http://localhost:(\d+)/\?token=a-token; ')[1])
    console.expect('^it is not encrypted')
    printed = [line for line in console.output.splitlines() if line.startswith('from other machines')]
    shown = [f'[{each}]' if ':' in each else each for each in found]
    assert printed == [f'from other machines it is at http://{each}:{port}/?token={TOKEN}' for each in shown]
    asked = f'GET /?token={TOKEN} HTTP/1.1\r\nHost: robot:{port}\r\nConnection: close\r\n\r\n'.encode()
    for loopback in loopbacks:
        with socket.create_connection((loopback, port), timeout=PATIENCE) as link:
            link.sendall(asked)
            assert link.recv(65536).startswith(b'HTTP/1.1 200 ')


@pytest.mark.slow
def test_a_port_that_is_preferred_is_the_same_each_time_it_is_free(stage: Stage) -> None:
    served = r'^the console is at (http://localhost:(\d+)/); '

    def start(*ports: str) -> tuple[Program, re.Match[str]]:
        console = stage.program(CONSOLE, 'console', '--no-open', *ports)
        return console, console.expect(served)

    first, found = start('--port', '0')
    url, port = found[1], found[2]
    second, other = start('--prefer-port', port)
    assert other[1] != url
    assert f'port {port} is taken: the address is another one this time\n' in second.output
    for _ in range(2):
        first.send_signal(signal.SIGINT)
        first.wait()
        first, found = start('--prefer-port', port)
        assert found[1] == url
        assert 'is taken' not in first.output


@pytest.mark.slow
def test_a_key_with_a_password_is_refused_and_not_asked_for(stage: Stage, tmp_path: Path) -> None:
    trustme = pytest.importorskip('trustme')
    serialization = pytest.importorskip('cryptography.hazmat.primitives.serialization')
    certificate = trustme.CA().issue_cert('localhost')
    key, chain = tmp_path / 'key.pem', tmp_path / 'cert.pem'
    plain = serialization.load_pem_private_key(certificate.private_key_pem.bytes(), None)
    key.write_bytes(
        plain.private_bytes(
            serialization.Encoding.PEM,
            serialization.PrivateFormat.PKCS8,
            serialization.BestAvailableEncryption(b'secret'),
        )
    )
    certificate.cert_chain_pems[0].write_to_path(str(chain))
    console = stage.program(
        CONSOLE, 'console', '--no-open', '--port', '0', '--tls-cert', str(chain), '--tls-key', str(key)
    )
    assert 0 < console.wait() < 12
    assert 'the TLS files cannot be used' in console.output


@pytest.mark.slow
@pytest.mark.parametrize(
    ('arguments', 'problem'),
    [
        (['--tls-cert', '/nowhere'], 'give both --tls-cert and --tls-key'),
        (['--tls-cert', '/nowhere', '--tls-key', '/nowhere'], 'the TLS files cannot be used'),
        (['--token', 'a b'], 'a token is made of'),
        (['--host', '203.0.113.7'], 'choose another --port'),
        (['--port', '70000'], 'from 0 to 65535'),
    ],
)
def test_what_cannot_be_served_is_told_in_one_line(stage: Stage, arguments: list[str], problem: str) -> None:
    console = stage.program(CONSOLE, 'console', '--no-open', '--port', '0', *arguments)
    assert 0 < console.wait() < 12
    told = [line for line in console.output.splitlines() if not line.startswith('[')]
    assert problem in told[-1]
    assert 'Traceback' not in console.output
