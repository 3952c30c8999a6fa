"""TLS between sessions of ours and of eclipse-zenoh: messages, certificates, names, strangers."""

from __future__ import annotations

import json
import socket
from collections.abc import Callable, Iterator
from datetime import UTC, datetime, timedelta
from pathlib import Path
from threading import Event
from typing import NamedTuple

import pytest
import trustme
from fuzz.targets import client_hello
from helpers.patience import PATIENCE, wait_for
from helpers.zenoh_sides import Ours, Portable, Side, Theirs, address

from goalwire.errors import TransportError
from goalwire.records import replace
from goalwire.transport.zenoh.settings.native import BeyondOursError, native_settings
from goalwire.zenoh.io import fault_log
from goalwire.zenoh.io.endpoints import TlsFiles, parse
from goalwire.zenoh.io.tls import TlsSocketLink, TlsStream, client_context, server_context
from goalwire.zenoh.protocol import bounds

PAIRS = [(Ours, Ours), (Ours, Theirs), (Theirs, Ours), (Portable, Portable)]
MAKES = pytest.mark.parametrize('makes', PAIRS, ids=lambda pair: f'{pair[0].make}-{pair[1].make}')
Open = Callable[..., Side]


class Certificates(NamedTuple):
    """The files of one authority: who it vouches for, and what for."""

    files: TlsFiles
    nameless: TlsFiles
    """The same authority's certificate for another host."""
    expired: TlsFiles


LONG_AGO = datetime(2020, 1, 1, tzinfo=UTC)


def _issue(
    folder: Path, authority: trustme.CA, host: str, *, mtls: bool, until: datetime | None = None
) -> TlsFiles:
    folder.mkdir(parents=True)
    authority.cert_pem.write_to_path(str(folder / 'ca.pem'))
    # eclipse-zenoh before 1.9 panics without a common name
    issued = authority.issue_cert(host, common_name=host, not_before=LONG_AGO, not_after=until)
    issued.private_key_pem.write_to_path(str(folder / 'key.pem'))
    with (folder / 'cert.pem').open('wb') as file:
        for part in issued.cert_chain_pems:
            file.write(part.bytes())
    return TlsFiles(
        root_ca_certificate=str(folder / 'ca.pem'),
        listen_certificate=str(folder / 'cert.pem'),
        listen_private_key=str(folder / 'key.pem'),
        connect_certificate=str(folder / 'cert.pem'),
        connect_private_key=str(folder / 'key.pem'),
        enable_mtls=mtls,
        verify_name_on_connect=True,
    )


@pytest.fixture(scope='module')
def certificates(tmp_path_factory: pytest.TempPathFactory) -> Certificates:
    folder, authority = tmp_path_factory.mktemp('tls'), trustme.CA()
    return Certificates(
        _issue(folder / 'here', authority, '127.0.0.1', mtls=True),
        _issue(folder / 'there', authority, 'robot.example', mtls=True),
        _issue(folder / 'old', authority, '127.0.0.1', mtls=True, until=LONG_AGO + timedelta(days=1)),
    )


@pytest.fixture(scope='module')
def strangers(tmp_path_factory: pytest.TempPathFactory) -> TlsFiles:
    """The files of an authority that nobody else knows."""
    return _issue(tmp_path_factory.mktemp('strangers') / 'all', trustme.CA(), '127.0.0.1', mtls=True)


@pytest.fixture
def warnings(monkeypatch: pytest.MonkeyPatch) -> list[str]:
    """The warnings of sessions."""
    told: list[str] = []
    monkeypatch.setattr(fault_log.FaultLog, 'warn', lambda _, text: told.append(text))
    return told


@pytest.fixture
def open_side() -> Iterator[Open]:
    """Opens sessions, which are closed after the test, the last first."""
    opened: list[Side] = []

    def start(make: type[Side], **settings: object) -> Side:
        opened.append(make('peer', **settings))  # type: ignore[call-arg]
        return opened[-1]

    yield start
    for side in reversed(opened):
        side.close()


@pytest.fixture
def pair(
    makes: tuple[type[Side], type[Side]], certificates: Certificates, open_side: Open
) -> tuple[Side, Side]:
    where = address('tls')
    one = open_side(makes[0], listen=(where,), tls=certificates.files)
    other = open_side(makes[1], connect=(where,), tls=certificates.files)
    wait_for(lambda: other.id in one.links() and one.id in other.links(), 'the link')
    return one, other


@MAKES
def test_messages_of_all_sizes_arrive_in_order_both_ways(pair: tuple[Side, Side]) -> None:
    for sender, receiver in (pair, pair[::-1]):
        heard = receiver.subscribe('a/*')
        watch = sender.watch(f'ready/{sender.id}')
        receiver.token(f'ready/{sender.id}')
        watch.wait(1)
        sizes = [0, 1, 127, 16383, 16384, 65535, 65536, 1_000_000, 20_000_000, 3]
        for size in sizes:
            sender.put('a/b', bytes(size))
        assert [(key, len(payload or b'')) for key, payload in heard.wait(len(sizes))] == [
            ('a/b', size) for size in sizes
        ]


@MAKES
def test_queries_are_answered_both_ways(pair: tuple[Side, Side]) -> None:
    for number, (client, server) in enumerate((pair, pair[::-1])):
        server.serve(f'q/{number}', b'yes ')
        wait_for(lambda: client.ask(f'q/{number}').wait(), 'the queryable')  # noqa: B023
        assert client.ask(f'q/{number}', bytes(300_000)).wait() == [(f'q/{number}', b'yes ' + bytes(300_000))]


@pytest.mark.parametrize('make', [Ours, Theirs])
def test_who_shows_a_certificate_of_another_authority_is_refused_and_told_of_once(
    certificates: Certificates, strangers: TlsFiles, open_side: Open, warnings: list[str], make: type[Side]
) -> None:
    where = address('tls')
    listener = open_side(Ours, listen=(where,), tls=certificates.files)
    trusting = replace(strangers, root_ca_certificate=certificates.files.root_ca_certificate)
    stranger = open_side(make, connect=(where,), tls=trusting)
    wait_for(lambda: any('TLS: ' in line and 'certificate' in line for line in warnings), 'the warning')
    friend = open_side(Ours, connect=(where,), tls=certificates.files)
    wait_for(lambda: friend.id in listener.links(), 'the link')
    assert stranger.id not in listener.links()
    assert len(set(warnings)) == len(warnings)


def test_a_listener_of_another_authority_is_refused(
    certificates: Certificates, strangers: TlsFiles, open_side: Open, warnings: list[str]
) -> None:
    where = address('tls')
    open_side(Ours, listen=(where,), tls=replace(strangers, enable_mtls=False))
    caller = open_side(Ours, connect=(where,), tls=certificates.files)
    wait_for(lambda: [line for line in warnings if 'is not accepted' in line], 'the warning')
    assert not caller.links()


@pytest.mark.parametrize('make', [Ours, Theirs])
def test_a_certificate_for_another_host_is_refused_unless_names_are_not_checked(
    certificates: Certificates, open_side: Open, warnings: list[str], make: type[Side]
) -> None:
    where = address('tls')
    open_side(make, listen=(where,), tls=certificates.nameless)
    caller = open_side(Ours, connect=(where,), tls=certificates.files)
    wait_for(lambda: [line for line in warnings if 'IP address mismatch' in line], 'the warning')
    assert not caller.links()
    careless = open_side(
        Ours, connect=(where,), tls=replace(certificates.files, verify_name_on_connect=False)
    )
    wait_for(careless.links, 'the link')


@pytest.mark.parametrize(
    ('server', 'client', 'advice_there', 'advice_here'),
    [
        (
            'expired',
            'files',
            "renew the other side's certificate",
            "refuses this side's certificate: renew it",
        ),
        (
            'files',
            'expired',
            "refuses this side's certificate: renew it",
            "renew the other side's certificate",
        ),
        ('nameless', 'files', 'it must name the host that is dialled', 'name the host dialled?'),
        ('files', 'nobody', 'connect_private_key here', 'did not return a certificate; set enable'),
        ('strangers', 'files', 'must hold the authority that signed it', 'must hold the authority of this'),
    ],
    ids=['server expired', 'client expired', 'other host', 'client without one', 'other authority'],
)
def test_a_refusal_says_on_either_side_what_to_do(
    certificates: Certificates,
    strangers: TlsFiles,
    open_side: Open,
    warnings: list[str],
    server: str,
    client: str,
    advice_there: str,
    advice_here: str,
) -> None:
    """And who is refused is let in once what was wrong is mended: the listener starts anew."""
    files = certificates._asdict() | {
        'nobody': replace(certificates.files, enable_mtls=False),
        'strangers': replace(strangers, enable_mtls=False),
    }
    where = address('tls')
    listener = open_side(Ours, listen=(where,), tls=files[server])
    caller = open_side(Ours, connect=(where,), tls=files[client])
    for advice in (advice_there, advice_here):
        wait_for(lambda: [line for line in warnings if advice in line], advice)  # noqa: B023
    assert all('\n' not in line for line in warnings)
    assert not caller.links()
    listener.close()
    mended = open_side(Ours, listen=(where,), tls=replace(certificates.files, enable_mtls=client == 'files'))
    if client != 'expired':
        wait_for(lambda: caller.id in mended.links(), 'the link')


def test_a_stranger_without_tls_ends_its_own_connection_alone(
    certificates: Certificates, open_side: Open, warnings: list[str]
) -> None:
    where = address('tls')
    listener = open_side(Ours, listen=(where,), tls=certificates.files)
    at = parse(where)
    with socket.create_connection((at.host, at.port), timeout=10) as stranger:
        stranger.sendall(b'GET / HTTP/1.1\r\n\r\n')
        while stranger.recv(4096):
            pass
    friend = open_side(Ours, connect=(where,), tls=certificates.files)
    wait_for(lambda: friend.id in listener.links(), 'the link')
    assert [line for line in warnings if 'TLS: http request' in line]


@pytest.mark.parametrize(
    'said',
    [b'', client_hello()[:40], b'\x16\x03\x01\xff\xff'],
    ids=['nothing', 'half a hello', 'a record of any length'],
)
def test_one_that_does_not_shake_hands_is_hung_up_on(
    certificates: Certificates,
    open_side: Open,
    warnings: list[str],
    monkeypatch: pytest.MonkeyPatch,
    said: bytes,
) -> None:
    monkeypatch.setattr(bounds, 'HANDSHAKE_S', 0.2)
    where = address('tls')
    open_side(Ours, listen=(where,), tls=certificates.files)
    at = parse(where)
    with socket.create_connection((at.host, at.port), timeout=PATIENCE) as stranger:
        stranger.sendall(said)
        while stranger.recv(4096):
            pass
    wait_for(lambda: warnings, 'a warning')
    assert len(warnings) == 1


def test_a_link_that_ended_before_it_began_leaves_its_descriptor_to_others(
    certificates: Certificates, open_side: Open, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Its number may belong to another file by then."""
    ended, start = Event(), TlsSocketLink.start

    def end_and_start(link: TlsSocketLink) -> None:
        link.end('the session is being closed')
        start(link)
        ended.set()

    monkeypatch.setattr(TlsSocketLink, 'start', end_and_start)
    where = address('tls')
    open_side(Ours, listen=(where,), tls=certificates.files)
    with socket.create_connection(('127.0.0.1', parse(where).port)):
        assert ended.wait(PATIENCE)


def test_a_full_link_loses_nothing(certificates: Certificates, open_side: Open) -> None:
    where = address('tls')
    one = open_side(Ours, listen=(where,), tls=certificates.files)
    other = open_side(Ours, connect=(where,), tls=certificates.files)
    heard = other.subscribe('big')
    watch = one.watch('up')
    other.token('up')
    watch.wait(1)
    for number in range(40):
        one.put('big', bytes((number,)) * 500_000)
    assert [payload[:1] for _, payload in heard.wait(40) if payload] == [bytes((n,)) for n in range(40)]


class Interrupted:
    """A connected socket: after each time that it has sent, a signal's handler runs."""

    def __init__(self, sock: socket.socket) -> None:
        self.recv = sock.recv
        self.handler: Callable[[], None] | None = None
        self._send = sock.send

    def send(self, data: memoryview, flags: int) -> int:
        sent = self._send(data[:1000], flags)
        handler, self.handler = self.handler, None
        if handler is not None:
            handler()
        return sent


@pytest.mark.parametrize('flushes', [False, True])
def test_a_signals_handler_that_sends_does_not_tear_the_stream(
    certificates: Certificates, flushes: bool
) -> None:
    """It runs within `send` or `flush`, on the same thread: nothing is sent twice, or between two halves."""
    near, far = socket.socketpair()
    near.setblocking(False)
    far.setblocking(False)
    interrupted = Interrupted(near)
    ours = TlsStream(interrupted, client_context(certificates.files), '127.0.0.1')  # type: ignore[arg-type]
    theirs = TlsStream(far, server_context(certificates.files), None)
    done = [False, False]
    while not all(done):
        done = [ours.shake_hands() or done[0], theirs.shake_hands() or done[1]]
    late: list[bytes] = []

    def handler() -> None:
        try:
            assert ours.send(b'late') == 4
        except BlockingIOError:
            late.append(b'late')  # a link keeps it, and sends it when there is room

    sent = b'x' * 5000
    if flushes:  # what was encrypted waits, and is flushed when the socket has room
        ours._tls.write(sent)
        interrupted.handler = handler
        assert ours.flush()
    else:
        interrupted.handler = handler
        assert ours.send(sent) == len(sent)
    for each in late:
        ours.send(each)
    assert theirs.recv(65536) == sent + b'late'
    near.close()
    far.close()


@pytest.mark.parametrize(
    ('change', 'said'),
    [
        ({'listen_certificate': ''}, 'TLS needs transport/link/tls/listen_certificate'),
        (
            {'listen_private_key': '/nowhere.pem'},
            "listen_private_key: '/nowhere.pem' cannot be used: No such file",
        ),
        ({'root_ca_certificate': '/nowhere.pem'}, "root_ca_certificate: '/nowhere.pem' cannot be used"),
    ],
)
def test_a_file_that_cannot_be_used_is_named(
    certificates: Certificates, change: dict[str, str], said: str
) -> None:
    with pytest.raises(TransportError, match=said):
        Ours('peer', listen=(address('tls'),), tls=replace(certificates.files, **change))


def test_a_configuration_says_which_files() -> None:
    text = """{"mode": "peer", "listen": {"endpoints": ["tls/0.0.0.0:7447"]}, "connect": {"endpoints": []},
        "scouting": {"multicast": {"enabled": false}, "gossip": {"enabled": false}},
        "transport": {"shared_memory": {"enabled": false},
        "link": {"tls": {"root_ca_certificate": "/ca.pem", "enable_mtls": true,
        "verify_name_on_connect": false}}}}"""
    settings = native_settings(json.loads(text))
    assert settings.tls == TlsFiles(
        root_ca_certificate='/ca.pem', enable_mtls=True, verify_name_on_connect=False
    )
    inline = text.replace('"root_ca_certificate"', '"root_ca_certificate_base64"')
    with pytest.raises(BeyondOursError, match='root_ca_certificate_base64'):
        native_settings(json.loads(inline))
