"""Handshakes that are cut short, recorded, stolen or far too large: they get no link, and others are served.

The attackers speak over bare sockets; the robot is a session that keeps a policy.
"""

from __future__ import annotations

import shutil
import socket
import ssl
import threading
from collections.abc import Callable, Iterator
from contextlib import ExitStack, closing, suppress
from datetime import timedelta
from pathlib import Path

import pytest
from cryptography import x509
from cryptography.hazmat.primitives import hashes
from cryptography.hazmat.primitives.asymmetric import ec
from cryptography.x509.oid import NameOID
from helpers.patience import PATIENCE, wait_for
from helpers.secured_site import (
    MARKER,
    OPEN,
    SERVICES,
    Robot,
    Site,
    exchange,
    files_of,
    of_another_authority,
    opened,
    policy_of,
)
from helpers.zenoh_sides import Ours, Side

from goalwire.records import replace
from goalwire.security import certificates
from goalwire.security.keystore import Keystore
from goalwire.security.policy import Verb
from goalwire.zenoh.io.endpoints import TlsFiles, parse
from goalwire.zenoh.protocol import bounds


@pytest.fixture(scope='module')
def made(tmp_path_factory: pytest.TempPathFactory) -> Keystore:
    keystore = Keystore.create(tmp_path_factory.mktemp('attacked') / 'keys')
    for name in ('robby', 'ann', 'mallory'):
        keystore.add(name, 'robot', ())
    return keystore


@pytest.fixture
def site(made: Keystore, tmp_path: Path) -> Iterator[Site]:
    shutil.copytree(made.path, tmp_path / 'keys')
    with ExitStack() as stack:
        yield Site(Keystore(tmp_path / 'keys'), policy_of({verb: ['/**'] for verb in Verb}), stack)


def _address(site: Site) -> tuple[str, int]:
    endpoint = parse(site.robot.where)
    return endpoint.host, endpoint.port


def _context(files: TlsFiles) -> ssl.SSLContext:
    context = ssl.SSLContext(ssl.PROTOCOL_TLS_CLIENT)
    context.check_hostname = False
    context.load_verify_locations(files.root_ca_certificate)
    context.load_cert_chain(files.connect_certificate, files.connect_private_key)
    return context


def _is_served(site: Site) -> bool:
    """Whether an honest session gets a link, and its messages arrive."""
    honest = site.keep(Robot(site.keystore, 'ann', (site.robot.where,), listens=False))
    return MARKER in exchange(honest, site.robot, last=MARKER)


def _mallory(site: Site, files: TlsFiles) -> Side:
    return Ours('client', connect=(site.robot.where,), tls=files)


def _is_hung_up(sock: socket.socket) -> bool:
    """Wait for the other side to hang up; what it says before is not of interest."""
    sock.settimeout(PATIENCE)
    with suppress(ConnectionError, ssl.SSLError):
        while sock.recv(4096):
            pass
    return True


# ---- half handshakes


def _connect(site: Site) -> socket.socket:
    return socket.create_connection(_address(site), PATIENCE)


def _begin_tls(site: Site) -> socket.socket:
    sock = _connect(site)
    sock.sendall(bytes.fromhex('1603010200010001fc0303'))  # the head of a ClientHello of 508 bytes
    return sock


def _end_tls(site: Site) -> socket.socket:
    return _context(files_of(site.keystore, 'mallory')).wrap_socket(_connect(site))


@pytest.mark.parametrize('begin', [_connect, _begin_tls, _end_tls], ids=['connected', 'hello', 'encrypted'])
def test_half_handshakes_keep_nobody_out(site: Site, begin: Callable[[Site], socket.socket]) -> None:
    """More connections than may be in their handshake at once: the oldest make room."""
    with ExitStack() as stack:
        first, *_ = [stack.enter_context(closing(begin(site))) for _ in range(bounds.MOST_GREETINGS + 1)]
        assert _is_served(site)
        assert _is_hung_up(first)


@pytest.mark.slow
def test_calls_are_answered_during_a_flood_of_handshakes(site: Site) -> None:
    """Strangers whose certificates are of another authority: each costs the robot a signature."""
    flood = _context(of_another_authority(site.keystore))
    honest = site.keep(Robot(site.keystore, 'ann', (site.robot.where,), listens=False))
    site.robot.serve(SERVICES[Verb.CALL], b'done')
    exchange(site.robot, honest, last=OPEN)
    ended = threading.Event()
    refused: list[bool] = []

    def knock() -> None:
        while not ended.is_set():
            with closing(_connect(site)) as sock, suppress(OSError):
                tls = flood.wrap_socket(sock)
                refused.append(_is_hung_up(tls))
                tls.close()

    strangers = [threading.Thread(target=knock, name='stranger') for _ in range(4)]
    for each in strangers:
        each.start()
    try:
        wait_for(lambda: len(refused) > 20)
        answered = [honest.ask(SERVICES[Verb.CALL]).wait() for _ in range(200)]
        wait_for(lambda: len(refused) > 100)
    finally:
        ended.set()
        for each in strangers:
            each.join()
    assert all(answers == [(SERVICES[Verb.CALL], b'done')] for answers in answered)
    wait_for(lambda: len(site.robot.protocol.links) == 1)


# ---- recorded, stolen


class Recorder:
    """A relay for one connection, which keeps the bytes that the client sends."""

    def __init__(self, target: tuple[str, int]) -> None:
        self.said = b''
        self._listener = socket.create_server(('127.0.0.1', 0))
        self.where = f'tls/127.0.0.1:{self._listener.getsockname()[1]}'
        self._target = target
        self._thread = threading.Thread(target=self._run, name='recorder')
        self._thread.start()

    def _run(self) -> None:
        client, _ = self._listener.accept()
        server = socket.create_connection(self._target, PATIENCE)
        back = threading.Thread(target=self._pump, args=(server, client, False), name='recorder-back')
        back.start()
        self._pump(client, server, True)
        back.join()
        client.close()
        server.close()

    def _pump(self, source: socket.socket, target: socket.socket, keeps: bool) -> None:
        source.settimeout(None)
        with suppress(OSError):
            while data := source.recv(65536):
                if keeps:
                    self.said += data
                target.sendall(data)
        with suppress(OSError):
            target.shutdown(socket.SHUT_WR)

    def close(self) -> None:
        self._thread.join()
        self._listener.close()


def test_a_recorded_session_that_is_played_again_gets_no_link(site: Site) -> None:
    with closing(Recorder(_address(site))) as recorder:
        honest = Robot(site.keystore, 'ann', (recorder.where,), listens=False)
        exchange(honest, site.robot, last=MARKER)
        honest.close()
    wait_for(lambda: not site.robot.protocol.links)
    recorded = list(site.robot_heard.samples)
    with closing(_connect(site)) as again:
        again.sendall(recorder.said)
        assert _is_hung_up(again)
    assert _is_served(site)
    assert set(site.robot_heard.samples[len(recorded) :]).isdisjoint(recorded)
    assert len(site.robot.protocol.links) == 1


def test_a_stolen_key_is_of_use_until_it_is_revoked_and_never_again(site: Site) -> None:
    keystore = site.keystore
    stolen = keystore.path / 'stolen.pem'
    shutil.copy(keystore.identity_path('mallory'), stolen)
    files = replace(
        files_of(keystore, 'mallory'), connect_certificate=str(stolen), connect_private_key=str(stolen)
    )
    with opened(lambda: _mallory(site, files)) as thief:
        assert thief is not None
        keystore.revoke('mallory')
        wait_for(lambda: not site.robot.protocol.links)
    keystore.issue('mallory', 'robot')
    wait_for(lambda: _gets_a_link(site, files_of(keystore, 'mallory')), 'a link with the new certificate')
    assert not _gets_a_link(site, files)


def _gets_a_link(site: Site, files: TlsFiles) -> bool:
    with opened(lambda: _mallory(site, files)) as side:
        return side is not None


def test_nothing_is_kept_by_which_a_session_of_tls_could_be_resumed(site: Site) -> None:
    """A resumed session shows no certificate again: one that was revoked since would go unnoticed."""
    context = _context(files_of(site.keystore, 'mallory'))
    with context.wrap_socket(_connect(site)) as first:
        first.sendall(b'\5\0nothing that Zenoh knows')
        assert _is_hung_up(first)
        session = first.session
    with context.wrap_socket(_connect(site), session=session) as second:
        assert not second.session_reused


# ---- downgrades


@pytest.mark.parametrize('version', [ssl.TLSVersion.TLSv1, ssl.TLSVersion.TLSv1_1, ssl.TLSVersion.TLSv1_2])
@pytest.mark.filterwarnings('ignore:ssl.TLSVersion')
def test_older_versions_of_tls_are_not_spoken(site: Site, version: ssl.TLSVersion) -> None:
    context = _context(files_of(site.keystore, 'mallory'))
    context.set_ciphers('DEFAULT:@SECLEVEL=0')
    context.minimum_version = context.maximum_version = version
    with closing(_connect(site)) as sock, pytest.raises((ssl.SSLError, ConnectionError)):
        context.wrap_socket(sock)


def test_a_plain_session_in_between_gets_no_links_of_a_robot_that_dials(site: Site) -> None:
    """Somebody answers at the address that a robot dials, and speaks Zenoh without TLS."""
    with closing(Ours('peer', listen=('tcp/127.0.0.1:0',))) as between:
        plain = between.protocol.gossip.locators[0]
        robot = site.keep(Robot(site.keystore, 'robby', (plain.replace('tcp/', 'tls/'),), listens=False))
        assert robot.protocol.links == ()
        assert between.protocol.links == ()


# ---- certificates that are bombs


def _signed(
    keystore: Keystore, subject: x509.Name, *, others: tuple[str, ...] = (), by_itself: bool = False
) -> TlsFiles:
    """Return files with a certificate on which the attacker has written what it likes."""
    key = ec.generate_private_key(ec.SECP256R1())
    site = keystore.site()
    now = certificates.now()
    builder = (
        x509.CertificateBuilder()
        .subject_name(subject)
        .issuer_name(subject if by_itself else site.certificate.subject)
        .public_key(key.public_key())
        .serial_number(x509.random_serial_number())
        .not_valid_before(now - timedelta(hours=1))
        .not_valid_after(now + timedelta(days=1))
    )
    if others:
        builder = builder.add_extension(
            x509.SubjectAlternativeName(map(x509.DNSName, others)), critical=False
        )
    certificate = builder.sign(key if by_itself else site.key, hashes.SHA256())
    path = keystore.path / 'bomb.pem'
    path.write_bytes(certificates.Pair(key, (certificate, *(() if by_itself else site.chain))).pem())
    return replace(
        files_of(keystore, 'mallory'), connect_certificate=str(path), connect_private_key=str(path)
    )


def _names(*names: str) -> x509.Name:
    return x509.Name([x509.NameAttribute(NameOID.COMMON_NAME, name) for name in names])


def _long_chain(keystore: Keystore) -> TlsFiles:
    """A chain of a hundred authorities, each of which vouches for the next."""
    pair = certificates.make_authority(certificates.now())
    chain = pair.chain
    for _ in range(100):
        pair = certificates.make_site(pair, certificates.now())
        chain = (*pair.chain, *chain)
    path = keystore.path / 'bomb.pem'
    path.write_bytes(certificates.Pair(pair.key, chain).pem())
    return replace(
        files_of(keystore, 'mallory'), connect_certificate=str(path), connect_private_key=str(path)
    )


BOMBS: dict[str, Callable[[Keystore], TlsFiles]] = {
    '50,000 other names': lambda keystore: _signed(
        keystore,
        _names('mallory'),
        others=tuple(f'{number}.example' for number in range(50_000)),
        by_itself=True,
    ),
    'a chain of 100': _long_chain,
    'two names': lambda keystore: _signed(keystore, _names('mallory', 'robby')),
    'no name': lambda keystore: _signed(keystore, x509.Name([])),
    'a name with a NUL': lambda keystore: _signed(keystore, _names('mallory\0robby')),
    'an unknown name': lambda keystore: _signed(keystore, _names('M' * 64)),
}


@pytest.mark.parametrize('kind', list(BOMBS))
def test_a_certificate_that_is_a_bomb_gets_no_link(site: Site, kind: str) -> None:
    assert not _gets_a_link(site, BOMBS[kind](site.keystore))
    assert site.robot.protocol.links == ()
    assert _is_served(site)
