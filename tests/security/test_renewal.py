"""Certificates that renew themselves: at the keystore's own authority, and over the network."""

from __future__ import annotations

import shutil
import socket
import ssl
from collections.abc import Iterator
from contextlib import contextmanager
from datetime import timedelta
from pathlib import Path
from threading import Thread
from time import time

import pytest
from helpers.isolation import free_port
from helpers.patience import wait_for

from goalwire.errors import SecurityError
from goalwire.security import certificate_succession, certificates, enrollment
from goalwire.security.authority import AuthorityServer
from goalwire.security.bundle import export, import_identity
from goalwire.security.environment import Chosen
from goalwire.security.keystore import Keystore
from goalwire.security.renewal import renew_if_due
from goalwire.security.renewal_thread import RenewalThread, is_possible

DAY = timedelta(days=1)


@pytest.fixture(scope='module')
def made(tmp_path_factory: pytest.TempPathFactory) -> Keystore:
    keystore = Keystore.create(tmp_path_factory.mktemp('renewed') / 'keys')
    for name in ('robby', 'ann'):
        keystore.add(name, 'robot', ())
    return keystore


@pytest.fixture
def keystore(made: Keystore, tmp_path: Path) -> Keystore:
    shutil.copytree(made.path, tmp_path / 'keys')
    return Keystore(tmp_path / 'keys')


def _make_due(keystore: Keystore, name: str, life: timedelta = DAY) -> None:
    """Give an identity a certificate of which three quarters are over."""
    identity = keystore.identity(name)
    now = certificates.now()
    begin = now - certificates.CLOCK_SKEW - 3 * life / 4
    kind = certificates.kind_of(identity.certificate)
    keystore.put(name, certificates.make_identity(keystore.site(), name, kind, (begin, now + life / 4)))


def _ignore(_connection: ssl.SSLSocket) -> None:
    """Nobody breaks the connection off."""


@contextmanager
def authority_of(keystore: Keystore) -> Iterator[tuple[str, list[str]]]:
    """Run an authority in the block; yields its address, and what it tells."""
    told: list[str] = []
    port = free_port()
    server = AuthorityServer(keystore, port, told.append)
    thread = Thread(target=server.serve_forever, name='authority', args=(0.01,))
    thread.start()
    try:
        yield f'https://localhost:{port}', told
    finally:
        server.shutdown()
        thread.join()
        server.server_close()


def _carry(keystore: Keystore, name: str, url: str) -> Keystore:
    """Carry an identity to another machine."""
    there = keystore.path.parent / f'{name}-keys'
    export(keystore, name, keystore.path.parent / 'file', url)
    import_identity(there, keystore.path.parent / 'file')
    return Keystore(there)


def test_a_certificate_is_renewed_after_two_thirds_of_its_life(keystore: Keystore) -> None:
    before = keystore.identity('robby').certificate
    due = renew_if_due(Chosen(keystore.path, 'robby'), _ignore)
    assert keystore.identity('robby').certificate == before
    assert 19 * 86400 < due - time() < 21 * 86400
    _make_due(keystore, 'robby')
    due = renew_if_due(Chosen(keystore.path, 'robby'), _ignore)
    assert 15 * 3600 < due - time() < 17 * 3600
    assert certificates.life_of(keystore.identity('robby').certificate) == DAY


def test_a_carried_identity_is_renewed_over_the_network(keystore: Keystore) -> None:
    _make_due(keystore, 'robby')
    with authority_of(keystore) as (url, told):
        robot = _carry(keystore, 'robby', url)
        before = robot.identity('robby')
        renew_if_due(Chosen(robot.path, 'robby'), _ignore)
    after = robot.identity('robby')
    assert after.key != before.key
    assert after.certificate.subject == before.certificate.subject
    assert certificates.life_of(after.certificate) == DAY
    certificates.verify(after.chain, keystore.trust())
    assert 'robby has a certificate that is valid until' in told[0]


@pytest.mark.parametrize('why', ['is revoked', 'does not name'])
def test_the_authority_refuses_those_who_may_do_nothing(keystore: Keystore, why: str) -> None:
    _make_due(keystore, 'robby')
    with authority_of(keystore) as (url, told):
        robot = _carry(keystore, 'robby', url)
        if why == 'is revoked':
            keystore.revoke('robby')
        else:
            keystore.policy_path.write_text('[identities]\nann = []\n')
        with pytest.raises(SecurityError, match=why):
            renew_if_due(Chosen(robot.path, 'robby'), _ignore)
    assert why in told[0]


def test_no_identity_of_the_site_can_stand_in_for_the_authority(
    keystore: Keystore, monkeypatch: pytest.MonkeyPatch
) -> None:
    _make_due(keystore, 'robby')
    with monkeypatch.context() as patched:
        patched.setattr(enrollment, 'AUTHORITY', 'robot')
        authority = authority_of(keystore)
        url, _ = authority.__enter__()
    try:
        robot = _carry(keystore, 'robby', url)
        with pytest.raises(SecurityError, match='is not the authority of this site'):
            renew_if_due(Chosen(robot.path, 'robby'), _ignore)
    finally:
        authority.__exit__(None, None, None)


def test_the_authority_of_another_site_is_not_asked(keystore: Keystore, tmp_path: Path) -> None:
    _make_due(keystore, 'robby')
    other = Keystore.create(tmp_path / 'other')
    with authority_of(other) as (url, _):
        robot = _carry(keystore, 'robby', url)
        with pytest.raises(OSError, match='certificate verify failed'):
            renew_if_due(Chosen(robot.path, 'robby'), _ignore)


def test_an_authority_that_cannot_be_reached_is_told_once_and_tried_again(keystore: Keystore) -> None:
    _make_due(keystore, 'robby', timedelta(seconds=60))
    robot = _carry(keystore, 'robby', f'https://localhost:{free_port()}')
    told: list[str] = []
    renewal = RenewalThread(Chosen(robot.path, 'robby'), told.append)
    try:
        renewal.begin_if_due()
        wait_for(lambda: told)
        assert "the certificate of 'robby' ends in 0.0 days and cannot be renewed: " in told[0]
        with authority_of(keystore) as (url, _):
            robot.authority_path.write_text(f'url = "{url}"\n')
            before = robot.identity('robby').certificate

            def is_renewed() -> bool:
                renewal.begin_if_due()
                return robot.identity('robby').certificate != before

            wait_for(is_renewed)
        assert len(told) == 1
    finally:
        renewal.close()


def test_closing_breaks_off_a_renewal_that_nobody_answers(keystore: Keystore) -> None:
    _make_due(keystore, 'robby')
    with socket.create_server(('127.0.0.1', 0)) as mute:
        robot = _carry(keystore, 'robby', f'https://127.0.0.1:{mute.getsockname()[1]}')
        renewal = RenewalThread(Chosen(robot.path, 'robby'), lambda _: None)
        renewal.begin_if_due()
        connection, _ = mute.accept()
        begun = time()
        renewal.close()
        assert time() - begun < 5
        connection.close()


def test_programs_without_anybody_who_renews_start_no_thread(keystore: Keystore) -> None:
    assert is_possible(Chosen(keystore.path, 'robby'))
    robot = _carry(keystore, 'robby', '')
    assert not is_possible(Chosen(robot.path, 'robby'))


@pytest.mark.parametrize(
    'url', ['192.168.0.7:7449', 'http://192.168.0.7:7449', 'https://a b:1', 'https://a"\n:1']
)
def test_an_address_that_is_none_is_refused(keystore: Keystore, url: str) -> None:
    with pytest.raises(SecurityError, match='write one like https'):
        export(keystore, 'robby', keystore.path / 'file', url)


# ---- shown over a link


def test_a_certificate_is_shown_by_who_has_its_key_to_whom_it_is_meant_for(keystore: Keystore) -> None:
    pair = keystore.identity('robby')
    shown = certificate_succession.show(pair, 'a1', 'b2')
    assert certificate_succession.read_shown(shown, 'b2', keystore.trust()) == ('a1', pair.certificate)
    with pytest.raises(SecurityError, match='has not its key'):
        certificate_succession.read_shown(shown, 'c3', keystore.trust())
    with pytest.raises(SecurityError, match='has not its key'):
        certificate_succession.read_shown(
            shown.replace(b'"session": "a1"', b'"session": "c3"'), 'b2', keystore.trust()
        )
    forged = certificates.Pair(certificates.make_key(), pair.chain)
    with pytest.raises(SecurityError, match='has not its key'):
        certificate_succession.read_shown(
            certificate_succession.show(forged, 'a1', 'b2'), 'b2', keystore.trust()
        )


def test_an_identity_cannot_vouch_for_another(keystore: Keystore) -> None:
    """robby signs a certificate for ann with the key of its own, which is not an authority's."""
    robby = keystore.identity('robby')
    now = certificates.now()
    forged = certificates.make_identity(robby, 'ann', 'robot', (now - DAY / 2, now + DAY))
    with pytest.raises(SecurityError, match='the certificate is not accepted'):
        certificate_succession.read_shown(
            certificate_succession.show(forged, 'a1', 'b2'), 'b2', keystore.trust()
        )


@pytest.mark.parametrize('message', [b'', b'[]', b'{}', b'{"session": "a"}', b'[' * 100_000, b'\xff'])
def test_what_shows_no_certificate_is_refused(keystore: Keystore, message: bytes) -> None:
    with pytest.raises(SecurityError, match='the message shows no certificate'):
        certificate_succession.read_shown(message, 'b2', keystore.trust())
