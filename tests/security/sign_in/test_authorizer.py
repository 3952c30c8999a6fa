"""People who sign in at a server with an identity: tokens, rights, and what the audit log says."""

from __future__ import annotations

import re
from collections.abc import Iterator
from contextlib import closing
from datetime import timedelta
from pathlib import Path

import pytest

from goalwire.errors import NotAllowedError, SecurityError
from goalwire.security import audit, storage
from goalwire.security.environment import Chosen
from goalwire.security.needs import Permission
from goalwire.security.policy import Verb
from goalwire.security.revocation import write_revoked
from goalwire.security.sign_in.authorizer import Authorizer
from goalwire.security.sign_in.signed_in import SignedIn
from goalwire.security.sign_in.tokens import delete_tokens, load_tokens, make_token, tokens_path

POLICY = """\
[roles.console]
call = ["/**"]
publish = ["/**"]
missions = true
[roles.operator]
call = ["/lamp", "/reset"]
publish = ["/cmd_vel", "/say"]
send = ["/walk"]
missions = true
[roles.guest]
stop = false
[moving]
call = ["/reset"]
[identities]
console = ["console"]
cy = []
ann = ["operator"]
bob = ["operator", "guest"]
"""


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    """A keystore without keys: whoever verifies certificates and tokens needs none."""
    (tmp_path / 'policy.toml').write_text(POLICY)
    (tmp_path / 'revoked.toml').write_text(write_revoked({}))
    return tmp_path


@pytest.fixture
def authorizer(folder: Path) -> Iterator[Authorizer]:
    with closing(Authorizer(Chosen(folder, 'console'))) as made:
        yield made


def _may(client: SignedIn, verb: Verb, name: str) -> bool:
    return not client.why_not(Permission((verb,), name))


def _entries(authorizer: Authorizer) -> list[dict[str, str]]:
    """Return the audit log once all is written."""
    authorizer.close()
    return list(audit.read(audit.log_path(authorizer.identity.folder, 'console')))


def test_a_token_names_who_has_it_and_only_its_hash_is_kept(folder: Path, authorizer: Authorizer) -> None:
    token = make_token(folder, 'ann')
    make_token(folder, 'bob')
    assert authorizer.find_principal(token).name == 'ann'
    assert token not in tokens_path(folder).read_text()
    assert tokens_path(folder).stat().st_mode & 0o777 == storage.PRIVATE
    with pytest.raises(SecurityError, match='the token is not known here'):
        authorizer.find_principal(token[:-1] + '\udcff')


def test_a_token_that_was_deleted_counts_no_more(folder: Path, authorizer: Authorizer) -> None:
    client = SignedIn(authorizer, authorizer.find_principal(make_token(folder, 'ann')))
    other = SignedIn(authorizer, authorizer.find_principal(make_token(folder, 'bob')))
    assert _may(client, Verb.CALL, '/lamp')
    assert delete_tokens(folder, 'ann') == 1
    assert client.problem() == "the token of 'ann' was deleted"
    assert not _may(client, Verb.CALL, '/lamp')
    assert not other.problem()


def test_a_token_ends_with_its_time_and_is_forgotten_then(folder: Path, authorizer: Authorizer) -> None:
    token = make_token(folder, 'ann', timedelta(seconds=-1))
    with pytest.raises(SecurityError, match="the token of 'ann' has expired"):
        authorizer.find_principal(token)
    make_token(folder, 'bob')
    assert [each.name for each in load_tokens(folder)] == ['bob']


def test_revoking_a_name_ends_its_tokens(folder: Path, authorizer: Authorizer) -> None:
    client = SignedIn(authorizer, authorizer.find_principal(make_token(folder, 'ann')))
    until = load_tokens(folder)[0].issued
    storage.replace(folder / 'revoked.toml', write_revoked({'ann': until}).encode())
    assert client.problem() == "the token of 'ann' is revoked"


def test_what_only_one_of_visitor_and_server_may_is_refused(folder: Path, authorizer: Authorizer) -> None:
    ann = SignedIn(authorizer, authorizer.find_principal(make_token(folder, 'ann')))
    assert _may(ann, Verb.CALL, '/lamp')
    assert re.search(
        r"policy\.toml:\d+: none of the roles of 'ann' may call '/shy'",
        ann.why_not(Permission((Verb.CALL,), '/shy')),
    )
    # The robots know only the console: what it may not do, nobody does through it.
    assert "none of the roles of 'console' may send '/walk'" in ann.why_not(Permission((Verb.SEND,), '/walk'))


def test_everybody_may_stop_whom_no_role_forbids_it(folder: Path, authorizer: Authorizer) -> None:
    ann, bob = (
        SignedIn(authorizer, authorizer.find_principal(make_token(folder, name))) for name in ('ann', 'bob')
    )
    ann.check_to_stop(['/estop'])
    with pytest.raises(NotAllowedError, match=r'guest: stop = false: nothing was stopped'):
        bob.check_to_stop(['/estop'])
    assert [(each['who'], each['outcome'], each['key']) for each in _entries(authorizer)] == [
        ('ann', 'stops', '/estop'),
        ('bob', 'was refused', '/estop'),
    ]


def test_missions_go_on_by_those_whom_a_role_allows_it(folder: Path, authorizer: Authorizer) -> None:
    ann, cy = (
        SignedIn(authorizer, authorizer.find_principal(make_token(folder, name))) for name in ('ann', 'cy')
    )
    ann.check_to_command('mission rounds m', 'approve', 'yes')
    with pytest.raises(NotAllowedError, match=r"none of the roles of 'cy' has missions = true: nothing was"):
        cy.check_to_command('mission rounds m', 'resume')
    cy.check_to_stop(['mission rounds m'], 'cancel')
    found = _entries(authorizer)
    assert [(each['who'], each['outcome'], each['act'], each.get('what', '')) for each in found] == [
        ('ann', 'moves', 'approve', 'yes'),
        ('cy', 'was refused', 'resume', ''),
        ('cy', 'stops', 'cancel', ''),
    ]
    assert {each['key'] for each in found} == {'mission rounds m'}


def test_missions_need_the_right_of_the_console_too(folder: Path, authorizer: Authorizer) -> None:
    ann = SignedIn(authorizer, authorizer.find_principal(make_token(folder, 'ann')))
    assert not ann.why_not_missions()
    storage.replace(folder / 'policy.toml', POLICY.replace('missions = true\n', '', 1).encode())
    assert "none of the roles of 'console' has missions = true" in ann.why_not_missions()
    storage.replace(folder / 'policy.toml', POLICY.replace('missions = true\n', '').encode())
    assert ann.problem() == "what 'ann' may do has changed"


def test_rights_that_change_are_a_reason_to_begin_anew(folder: Path, authorizer: Authorizer) -> None:
    ann, bob = (
        SignedIn(authorizer, authorizer.find_principal(make_token(folder, name))) for name in ('ann', 'bob')
    )
    before = POLICY.replace('ann = ["operator"]', '# a line\nann = ["operator"]')
    storage.replace(folder / 'policy.toml', before.encode())
    assert not ann.problem()
    storage.replace(folder / 'policy.toml', POLICY.replace('ann = ["operator"]', 'ann = []').encode())
    assert ann.problem() == "what 'ann' may do has changed"
    assert not bob.problem()


def test_a_policy_with_a_mistake_changes_nothing(folder: Path, authorizer: Authorizer) -> None:
    ann = SignedIn(authorizer, authorizer.find_principal(make_token(folder, 'ann')))
    storage.replace(folder / 'policy.toml', b'mode = "none"')
    assert _may(ann, Verb.CALL, '/lamp')


def test_the_log_says_who_did_what_and_with_what(folder: Path, authorizer: Authorizer) -> None:
    ann = SignedIn(authorizer, authorizer.find_principal(make_token(folder, 'ann')))
    ann.check_to_send(Permission((Verb.CALL,), '/lamp'), 'data: true')
    ann.check_to_send(Permission((Verb.CALL,), '/reset'))
    with pytest.raises(NotAllowedError, match='nothing was sent'):
        ann.check_to_send(Permission((Verb.CALL,), '/shy'))
    for _ in range(3):
        ann.check_to_send(Permission((Verb.PUBLISH,), '/cmd_vel'))
    found = _entries(authorizer)
    assert [(each['outcome'], each['act'], each['key']) for each in found] == [
        ('done', 'call', '/lamp'),
        ('moves', 'call', '/reset'),
        ('was refused', 'call', '/shy'),
        ('moves', 'publish', '/cmd_vel'),
        ('ended', 'publish', '/cmd_vel'),
    ]
    assert found[0]['what'] == 'data: true'
    assert found[0]['via'] == 'console'
    assert found[-1]['messages'] == '2'


def test_with_audit_what_is_forbidden_is_done_and_logged(folder: Path, authorizer: Authorizer) -> None:
    storage.replace(folder / 'policy.toml', f'mode = "audit"\n{POLICY}'.encode())
    ann = SignedIn(authorizer, authorizer.find_principal(make_token(folder, 'ann')))
    ann.check_to_send(Permission((Verb.CALL,), '/shy'))
    assert [each['outcome'] for each in _entries(authorizer)] == ['would be refused']


def test_a_file_of_tokens_that_is_damaged_lets_nobody_in(folder: Path) -> None:
    tokens_path(folder).write_text('[[ann]]\nsha256 = 3\n')
    with pytest.raises(SecurityError, match='is not what goalwire secure token has written'):
        Authorizer(Chosen(folder, 'console'))
