"""Attacks on a session with a policy: who gets a link, and what comes of each thing that is tried over it.

The attacker speaks Zenoh as it likes: its session knows no policy. Each attempt must end as the policy says.
"""

from __future__ import annotations

import shutil
import ssl
from collections.abc import Callable, Iterator
from contextlib import closing
from datetime import timedelta
from pathlib import Path
from threading import Event
from time import time

import pytest
from helpers.patience import PATIENCE, soon, wait_for
from helpers.secured_site import FEEDBACK, MARKER, OPEN, SERVICES, STRANGERS, TOPIC, Robot, files_of, key_of
from helpers.zenoh_sides import address

from goalwire.errors import SecurityError, TransportError
from goalwire.security import audit, certificate_succession
from goalwire.security.environment import Chosen
from goalwire.security.keystore import Keystore
from goalwire.security.policy import Verb
from goalwire.security.policy_file import load_policy
from goalwire.transport.zenoh.link_guard import LinkGuard
from goalwire.transport.zenoh.native_wire import NativeWire
from goalwire.transport.zenoh.policy_enforcement import LOOK_S, PolicyEnforcement
from goalwire.transport.zenoh.policy_questions import CERTIFICATE
from goalwire.zenoh.io.endpoints import TlsFiles
from goalwire.zenoh.io.native_session import NativeSession
from goalwire.zenoh.io.settings import Settings
from goalwire.zenoh.protocol.incoming_queries import Query
from goalwire.zenoh.protocol.network import ReplyError, Target
from goalwire.zenoh.protocol.publication import Publication
from goalwire.zenoh.protocol.querier import Querier
from goalwire.zenoh.protocol.queries import Answer
from goalwire.zenoh.protocol.session_protocol import SessionProtocol

EVERYONE = '[everyone]\npublish = ["/marker"]\nsubscribe = ["/open"]\n'
ROBOT = '[roles.robot]\n' + ''.join(f'{verb.value} = ["/**"]\n' for verb in Verb)


def _policy(*verbs: Verb, mode: str = 'enforce') -> str:
    """Return a policy by which mallory may do these to /secret, and nothing else but what everyone may."""
    role = '[roles.mallory]\n' + ''.join(f'{verb.value} = ["/secret"]\n' for verb in verbs)
    return f'mode = "{mode}"\n{EVERYONE}{ROBOT}{role}[identities]\nrobby = ["robot"]\nmallory = ["mallory"]\n'


@pytest.fixture(scope='module')
def made(tmp_path_factory: pytest.TempPathFactory) -> Keystore:
    keystore = Keystore.create(tmp_path_factory.mktemp('secured') / 'keys')
    keystore.add('robby', 'robot', ())
    keystore.add('mallory', 'program', ())
    keystore.add('nobody', 'program', ())
    return keystore


@pytest.fixture
def keystore(made: Keystore, tmp_path: Path) -> Keystore:
    shutil.copytree(made.path, tmp_path / 'keys')
    return Keystore(tmp_path / 'keys')


class Victim:
    """The session of a robot: it serves and publishes under the name /secret."""

    def __init__(self, keystore: Keystore, name: str = 'robby') -> None:
        self.where = address().replace('tcp/', 'tls/')
        security = PolicyEnforcement(Chosen(keystore.path, name))
        settings = Settings(listen=(self.where,), tls=files_of(keystore, name))
        self.wire = NativeWire(settings, security)
        self.protocol: SessionProtocol = self.wire.session.protocol
        self.got: list[str] = []
        self.marked = Event()
        for key in (TOPIC, MARKER):
            self.protocol.declare_subscriber(key, lambda sample: self._take(sample.key))
        for key in SERVICES.values():
            self.protocol.declare_queryable(key, self._answer, complete=True)
        self.token = f'@ros2_lv/0/{self.protocol.id}/0/0/NN/%/%/secret'
        self.protocol.declare_token(self.token)

    def _take(self, key: str) -> None:
        if key == MARKER:
            self.marked.set()
        else:
            self.got.append(key)

    def _answer(self, query: Query) -> None:
        self.got.append(query.key)
        query.answer(query.key, b'done')

    def close(self) -> None:
        self.wire.close()


def _connect(where: str, files: TlsFiles, zid: bytes = b'', patience: float = 0.0) -> NativeSession:
    return NativeSession(
        Settings(connect=(where,), listen=(), tls=files, zid=zid, must_connect=True, connecting_s=patience)
    )


@pytest.fixture
def victim(keystore: Keystore) -> Iterator[Callable[[str], Victim]]:
    opened: list[Victim] = []

    def open_victim(policy: str) -> Victim:
        keystore.policy_path.write_text(policy)
        opened.append(Victim(keystore))
        return opened[-1]

    yield open_victim
    for each in opened:
        each.close()


@pytest.fixture
def attacker(keystore: Keystore) -> Iterator[Callable[[Victim], NativeSession]]:
    opened: list[NativeSession] = []

    def open_attacker(victim: Victim, name: str = 'mallory', zid: bytes = b'') -> NativeSession:
        patience = 0.0 if zid else PATIENCE
        opened.append(_connect(victim.where, files_of(keystore, name), zid, patience))
        return opened[-1]

    yield open_attacker
    for each in opened:
        each.close()


def _put(session: SessionProtocol, key: str) -> None:
    publication = Publication(session, key)
    publication.put(b'x')
    publication.close()


def _mark(attacker: NativeSession, victim: Victim) -> None:
    """Have the victim take all that the attacker has sent so far."""
    _put(attacker.protocol, MARKER)
    assert soon(victim.marked)


def _ask(session: SessionProtocol, key: str) -> list[Answer]:
    answers: list[Answer] = []
    ended = Event()
    querier = Querier(session, key, target=Target.ALL_COMPLETE)
    querier.ask(b'', b'', answers.append, ended.set, PATIENCE)
    assert soon(ended)
    querier.close()
    return answers


# ---- what is tried; each returns whether it succeeded


def _pretend_to_know_nothing(attacker: NativeSession) -> None:
    """Have all sent, though the victim has not told who wants it: whoever attacks knows the names."""
    for link in attacker.protocol.links:
        link.peer.knows_all = False


def _publishes(attacker: NativeSession, victim: Victim, _verb: Verb) -> bool:
    _pretend_to_know_nothing(attacker)
    _put(attacker.protocol, TOPIC)
    _mark(attacker, victim)
    return TOPIC in victim.got


def _asks(attacker: NativeSession, victim: Victim, verb: Verb) -> bool:
    key = SERVICES[verb]
    _pretend_to_know_nothing(attacker)
    answers = _ask(attacker.protocol, key)
    refused = [each for each in answers if isinstance(each, ReplyError)]
    assert all(each.payload.startswith(b'denied: policy.toml:') for each in refused)
    assert bool(refused) is (key not in victim.got)
    return key in victim.got


def _hears(key: str) -> Callable[[NativeSession, Victim, Verb], bool]:
    def hear(attacker: NativeSession, victim: Victim, _verb: Verb) -> bool:
        heard: list[str] = []
        opened = Event()
        attacker.protocol.declare_subscriber(key, lambda sample: heard.append(sample.key))
        attacker.protocol.declare_subscriber(OPEN, lambda _: opened.set())
        _mark(attacker, victim)
        _put(victim.protocol, key)
        _put(victim.protocol, OPEN)
        assert soon(opened)
        return bool(heard)

    return hear


def _serves(attacker: NativeSession, victim: Victim, _verb: Verb) -> bool:
    key = key_of('/secret', 'a::srv::dds_::B_')
    attacker.protocol.declare_queryable(key, lambda query: query.answer(query.key, b'false'), complete=True)
    _mark(attacker, victim)
    return bool(_ask(victim.protocol, key))


def _runs(attacker: NativeSession, victim: Victim, _verb: Verb) -> bool:
    token = f'@ros2_lv/0/{attacker.id}/0/0/NN/%/%/secret'
    attacker.protocol.declare_token(token)
    _mark(attacker, victim)
    return token in victim.protocol.tokens('@ros2_lv/0/**')


def _looks(attacker: NativeSession, victim: Victim, _verb: Verb) -> bool:
    return victim.token in attacker.protocol.tokens('@ros2_lv/0/**')


ATTEMPTS: dict[Verb, Callable[[NativeSession, Victim, Verb], bool]] = {
    Verb.PUBLISH: _publishes,
    Verb.SUBSCRIBE: _hears(TOPIC),
    Verb.WATCH: _hears(FEEDBACK),
    **dict.fromkeys(SERVICES, _asks),
    Verb.SERVE: _serves,
    Verb.RUN: _runs,
    Verb.INTROSPECT: _looks,
}


def test_every_verb_is_tried() -> None:
    assert set(ATTEMPTS) == set(Verb)


@pytest.mark.parametrize('verb', list(Verb), ids=lambda verb: verb.value)
@pytest.mark.parametrize('others', [False, True], ids=['alone', 'all-others'])
def test_what_is_tried_ends_as_the_policy_says(
    keystore: Keystore,
    victim: Callable[[str], Victim],
    attacker: Callable[[Victim], NativeSession],
    verb: Verb,
    others: bool,
) -> None:
    """Allowed if the policy grants this verb alone, refused if it grants all the others."""
    # A client that may send goals sees them through, so SEND includes what WATCH allows.
    granted = [each for each in Verb if each is not verb and {each, verb} != {Verb.SEND, Verb.WATCH}]
    target = victim(_policy(*granted) if others else _policy(verb))
    says = load_policy(keystore.policy_path).decide('mallory', verb, '/secret').is_allowed
    assert says is not others
    assert ATTEMPTS[verb](attacker(target), target, verb) is says


@pytest.mark.parametrize('verb', [Verb.PUBLISH, Verb.CALL], ids=lambda verb: verb.value)
def test_audit_lets_through_what_it_logs(
    victim: Callable[[str], Victim], attacker: Callable[[Victim], NativeSession], verb: Verb
) -> None:
    target = victim(_policy(mode='audit'))
    session = attacker(target)
    if verb is Verb.CALL:
        assert [getattr(each, 'payload', b'') for each in _ask(session.protocol, SERVICES[verb])] == [b'done']
    else:
        assert ATTEMPTS[verb](session, target, verb)


def test_refusals_are_counted(
    victim: Callable[[str], Victim], attacker: Callable[[Victim], NativeSession]
) -> None:
    target = victim(_policy())
    session = attacker(target)
    _pretend_to_know_nothing(session)
    for _ in range(3):
        _put(session.protocol, TOPIC)
    _mark(session, target)
    assert target.wire.refused()['refused put'] == 3


@pytest.mark.parametrize('mode', ['enforce', 'audit'])
def test_what_is_refused_stands_in_the_audit_log(
    keystore: Keystore,
    victim: Callable[[str], Victim],
    attacker: Callable[[Victim], NativeSession],
    mode: str,
) -> None:
    target = victim(_policy(mode=mode))
    session = attacker(target)
    for _ in range(3):
        _publishes(session, target, Verb.PUBLISH)
    target.close()
    entries = [each for each in audit.read(audit.log_path(keystore.path, 'robby')) if each['key'] == TOPIC]
    (entry,) = [each for each in entries if each['act'] == 'put']
    assert entry['who'] == 'mallory'
    assert entry['outcome'] == ('was refused' if mode == 'enforce' else 'would be refused')
    assert "none of the roles of 'mallory' may publish '/secret'" in entry['reason']


@pytest.mark.parametrize(('side', 'verb'), [('pub', Verb.PUBLISH), ('sub', Verb.SUBSCRIBE)])
@pytest.mark.parametrize('is_allowed', [True, False])
def test_tokens_of_history_are_shown_by_those_who_may_use_the_topic(
    victim: Callable[[str], Victim],
    attacker: Callable[[Victim], NativeSession],
    side: str,
    verb: Verb,
    is_allowed: bool,
) -> None:
    target = victim(_policy(*([verb] if is_allowed else set(Verb) - {verb})))
    session = attacker(target)
    token = f'{TOPIC}/@adv/{side}/{session.id}/1/_'
    session.protocol.declare_token(token)
    _mark(session, target)
    assert (token in target.protocol.tokens(f'{TOPIC}/@adv/**')) is is_allowed


# ---- in another's name


def test_a_token_in_the_name_of_another_session_is_ignored(
    victim: Callable[[str], Victim], attacker: Callable[[Victim], NativeSession]
) -> None:
    target = victim(_policy(*Verb))
    session = attacker(target)
    token = f'@ros2_lv/0/{"1" * 32}/0/0/NN/%/%/secret'
    session.protocol.declare_token(token)
    _mark(session, target)
    assert token not in target.protocol.tokens('@ros2_lv/0/**')


def test_the_id_of_another_identitys_session_is_not_taken_over(
    keystore: Keystore, victim: Callable[[str], Victim], attacker: Callable[..., NativeSession]
) -> None:
    target = victim(_policy(*Verb) + 'nobody = []\n')
    honest = attacker(target)
    with pytest.raises(TransportError, match='no peer or router answers'):
        attacker(target, 'nobody', honest.protocol.zid)
    assert _publishes(honest, target, Verb.PUBLISH)


# ---- who gets no link at all


@pytest.mark.parametrize('kind', list(STRANGERS))
def test_a_stranger_gets_no_link(keystore: Keystore, victim: Callable[[str], Victim], kind: str) -> None:
    files = STRANGERS[kind](keystore)
    target = victim(_policy(*Verb))
    with pytest.raises(TransportError, match='no peer or router answers'):
        _connect(target.where, files)
    assert target.protocol.links == ()
    assert target.got == []


def test_a_stranger_without_tls_gets_no_link(victim: Callable[[str], Victim]) -> None:
    target = victim(_policy(*Verb))
    with pytest.raises(TransportError, match='no peer or router answers'):
        _connect(target.where.replace('tls/', 'tcp/'), TlsFiles())
    assert target.protocol.links == ()


def test_nobody_is_dialled_or_listened_to_without_tls(keystore: Keystore) -> None:
    keystore.policy_path.write_text(_policy())
    settings = Settings(listen=(address(),), tls=files_of(keystore, 'robby'))
    with pytest.raises(TransportError, match='is not protected, and security is on: write tls/'):
        NativeWire(settings, PolicyEnforcement(Chosen(keystore.path, 'robby')))


def test_a_server_that_is_not_of_the_site_is_not_talked_to(
    keystore: Keystore, victim: Callable[[str], Victim]
) -> None:
    """A robot that dials asks who has answered, as one that is dialled does."""
    target = victim(_policy())
    keystore.policy_path.write_text(_policy().replace('robby = ["robot"]', 'mallory2 = []'))
    settings = Settings(
        connect=(target.where,), listen=(), tls=files_of(keystore, 'mallory'), must_connect=True
    )
    with pytest.raises(TransportError, match="'robby' is not named in"):
        NativeWire(settings, PolicyEnforcement(Chosen(keystore.path, 'mallory')))


# ---- what changes while it runs


def test_the_link_of_a_revoked_identity_is_closed_within_seconds(
    keystore: Keystore, victim: Callable[[str], Victim], attacker: Callable[[Victim], NativeSession]
) -> None:
    target = victim(_policy(*Verb))
    session = attacker(target)
    keystore.revoke('mallory')
    wait_for(lambda: not target.protocol.links)
    wait_for(lambda: not session.is_connected())


@pytest.mark.slow
def test_a_link_is_closed_when_its_certificate_ends(
    keystore: Keystore, victim: Callable[[str], Victim], attacker: Callable[[Victim], NativeSession]
) -> None:
    keystore.identity_path('mallory').unlink()
    keystore.issue('mallory', 'program', timedelta(seconds=3))
    target = victim(_policy(*Verb))
    attacker(target)
    assert target.protocol.links
    wait_for(lambda: not target.protocol.links)


def test_a_policy_that_changes_holds_at_once(
    keystore: Keystore, victim: Callable[[str], Victim], attacker: Callable[[Victim], NativeSession]
) -> None:
    target = victim(_policy())
    session = attacker(target)
    assert not _publishes(session, target, Verb.PUBLISH)
    (before,) = target.protocol.links
    keystore.policy_path.write_text(_policy(Verb.PUBLISH))
    wait_for(lambda: target.protocol.links not in ((), (before,)) and bool(session.protocol.links))
    target.marked.clear()
    assert _publishes(session, target, Verb.PUBLISH)


def test_a_policy_with_a_mistake_changes_nothing(
    keystore: Keystore,
    victim: Callable[[str], Victim],
    attacker: Callable[[Victim], NativeSession],
    capfd: pytest.CaptureFixture[str],
) -> None:
    target = victim(_policy())
    session = attacker(target)
    keystore.policy_path.write_text('mode = "off"\n')
    told: list[str] = []

    def is_told() -> bool:
        told.append(capfd.readouterr().err)
        return 'the old one holds on' in ''.join(told)

    wait_for(is_told)
    assert not _publishes(session, target, Verb.PUBLISH)


def test_a_renewed_certificate_is_shown_on_new_links(
    keystore: Keystore, victim: Callable[[str], Victim]
) -> None:
    target = victim(_policy(*Verb))
    renewed = keystore.renew('robby')
    host, _, port = target.where.removeprefix('tls/').rpartition(':')

    def shown() -> int:
        context = ssl.create_default_context(cafile=str(keystore.trust_path))
        context.check_hostname = False
        own = str(keystore.identity_path('mallory'))
        context.load_cert_chain(own, own)
        import socket

        with socket.create_connection((host, int(port))) as sock, context.wrap_socket(sock) as tls:
            found = tls.getpeercert()
            assert found is not None
            return int(str(found['serialNumber']), 16)

    wait_for(lambda: shown() == renewed.certificate.serial_number)


@pytest.mark.slow
def test_a_link_lives_on_with_certificates_that_are_renewed(keystore: Keystore) -> None:
    """Both sides renew theirs while the link is there; the first ones have ended when it is used again."""
    keystore.policy_path.write_text(_policy(*Verb))
    for name in ('robby', 'mallory'):
        keystore.identity_path(name).unlink()
        keystore.issue(name, 'robot', timedelta(seconds=6))
    with closing(Robot(keystore)) as robot, closing(Robot(keystore, 'mallory', (robot.where,))) as other:
        heard = robot.subscribe(MARKER)
        (link,) = robot.protocol.links
        guards = [each.protocol.links[0].guard for each in (robot, other)]
        firsts = [guard.certificate.ends for guard in guards if isinstance(guard, LinkGuard)]
        wait_for(lambda: time() > max(firsts) + 2 * LOOK_S)
        other.put(MARKER, b'late')
        heard.wait(1)
        assert robot.protocol.links == (link,)
        assert all(guard.certificate.ends > time() for guard in guards if isinstance(guard, LinkGuard))


def test_a_certificate_of_somebody_else_is_not_taken_over_a_link(
    keystore: Keystore, victim: Callable[[str], Victim], attacker: Callable[[Victim], NativeSession]
) -> None:
    """mallory shows a certificate of nobody's with nobody's key, whose certificate ends later."""
    target = victim(_policy(*Verb))
    session = attacker(target)
    (link,) = target.protocol.links
    assert isinstance(link.guard, LinkGuard)
    before = link.guard.certificate
    stolen = keystore.renew('nobody', timedelta(days=90))
    publication = Publication(session.protocol, CERTIFICATE + target.wire.id)
    publication.put(certificate_succession.show(stolen, session.id, target.wire.id))
    publication.close()
    _mark(session, target)
    assert link.guard.certificate == before
    assert target.wire.session.rejects.counts()['renewed certificate'] == 1


def test_an_unusable_policy_is_an_error_of_opening(keystore: Keystore) -> None:
    keystore.policy_path.write_text('mode = 1')
    with pytest.raises(SecurityError, match='mode is 1'):
        PolicyEnforcement(Chosen(keystore.path, 'robby'))
