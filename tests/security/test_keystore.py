"""Keystores: what is made, what is never overwritten, and what lost power leaves."""

from __future__ import annotations

import os
import stat
import sys
from collections.abc import Callable
from datetime import timedelta
from functools import partial
from pathlib import Path

import pytest

from goalwire.errors import SecurityError
from goalwire.security import certificates
from goalwire.security.bundle import export, import_identity
from goalwire.security.keystore import Keystore
from goalwire.security.keystore_check import check
from goalwire.security.policy_file import load_policy


@pytest.fixture
def keystore(tmp_path: Path) -> Keystore:
    return Keystore.create(tmp_path / 'keys')


def test_a_new_keystore_has_nothing_wrong(keystore: Keystore) -> None:
    keystore.add('robby', 'robot', ())
    assert check(keystore) == []


def test_the_certificate_of_an_identity_leads_to_the_authority(keystore: Keystore) -> None:
    pair = keystore.add('robby', 'robot', ())
    trust = certificates.read_certificate(keystore.trust_path.read_bytes(), 'trust.pem')
    assert certificates.leads_to(pair.chain, trust)
    assert certificates.common_name(pair.certificate) == 'robby'
    assert certificates.kind_of(pair.certificate) == 'robot'


@pytest.mark.skipif(os.name != 'posix', reason='modes of files')
def test_keys_are_their_owners_alone(keystore: Keystore) -> None:
    keystore.add('robby', 'robot', ())
    before = os.umask(0)
    try:
        keystore.renew('robby')
    finally:
        os.umask(before)
    for name in ('authority.pem', 'site.pem', 'identities/robby.pem'):
        assert stat.S_IMODE((keystore.path / name).stat().st_mode) == 0o600
    assert stat.S_IMODE(keystore.path.stat().st_mode) == 0o700


def test_a_keystore_is_never_made_over_another(keystore: Keystore) -> None:
    before = (keystore.path / 'authority.pem').read_bytes()
    with pytest.raises(SecurityError, match='is there already; name a new folder'):
        Keystore.create(keystore.path)
    assert (keystore.path / 'authority.pem').read_bytes() == before
    assert [each.name for each in keystore.path.parent.iterdir()] == ['keys']


def test_an_identity_is_never_made_over_another(keystore: Keystore) -> None:
    keystore.add('robby', 'robot', ())
    before = keystore.identity_path('robby').read_bytes()
    with pytest.raises(SecurityError, match='is there already'):
        keystore.add('robby', 'robot', ())
    with pytest.raises(SecurityError, match='has a key already'):
        keystore.issue('robby', 'robot')
    assert keystore.identity_path('robby').read_bytes() == before


@pytest.mark.parametrize('name', ['', '../up', 'a/b', '.hidden', 'a b', 'x' * 65, 'ä'])
def test_a_name_that_is_no_file_name_is_refused(keystore: Keystore, name: str) -> None:
    with pytest.raises(SecurityError, match="cannot be an identity's name"):
        keystore.add(name, 'robot', ())


def test_renewing_brings_a_new_key_of_the_same_kind(keystore: Keystore) -> None:
    old = keystore.add('alice', 'person', ())
    new = keystore.renew('alice', timedelta(days=60))
    assert new.key.public_key() != old.key.public_key()
    assert certificates.kind_of(new.certificate) == 'person'
    assert new.certificate.not_valid_after_utc > old.certificate.not_valid_after_utc


def test_a_revoked_name_is_refused_until_it_is_issued_again(keystore: Keystore) -> None:
    keystore.add('alice', 'person', ())
    until = keystore.revoke('alice')
    assert keystore.list_revoked() == {'alice': until}
    assert keystore.names() == []
    again = keystore.issue('alice', 'person')
    assert again.certificate.not_valid_before_utc > until
    assert check(keystore) == []


def test_an_unreadable_list_of_revoked_names_is_an_error(keystore: Keystore) -> None:
    keystore.revoked_path.write_text('alice = "yesterday"\n')
    with pytest.raises(SecurityError, match="'alice' needs a time like"):
        keystore.list_revoked()
    assert any('needs a time like' in each.problem for each in check(keystore))


def test_check_tells_of_keys_that_others_can_read(keystore: Keystore) -> None:
    keystore.add('robby', 'robot', ())
    path = keystore.identity_path('robby')
    path.chmod(0o644)
    assert [each.problem for each in check(keystore)] == [
        f"'{path}' can be read by others; run chmod 600 {path}, and renew it"
    ]


def test_check_tells_of_certificates_that_end(keystore: Keystore) -> None:
    keystore.add('robby', 'robot', (), timedelta(days=1))
    (finding,) = check(keystore)
    assert not finding.is_error
    assert finding.problem.startswith("the certificate of 'robby' ends at")


def test_an_exported_identity_works_elsewhere(keystore: Keystore, tmp_path: Path) -> None:
    pair = keystore.add('robby', 'robot', ())
    export(keystore, 'robby', tmp_path / 'robby.identity')
    assert stat.S_IMODE((tmp_path / 'robby.identity').stat().st_mode) == 0o600
    assert import_identity(tmp_path / 'there', tmp_path / 'robby.identity') == 'robby'
    there = Keystore(tmp_path / 'there')
    assert there.identity('robby').pem() == pair.pem()
    assert check(there) == []
    with pytest.raises(SecurityError, match='has no authority that could sign'):
        there.renew('robby')


def test_an_import_brings_what_is_newer_and_forgets_no_revoked_name(
    keystore: Keystore, tmp_path: Path
) -> None:
    keystore.add('robby', 'robot', ())
    export(keystore, 'robby', tmp_path / 'old')
    import_identity(tmp_path / 'there', tmp_path / 'old')
    keystore.add('alice', 'person', ())
    keystore.revoke('alice')
    export(keystore, 'robby', tmp_path / 'new')
    import_identity(tmp_path / 'there', tmp_path / 'new')
    there = Keystore(tmp_path / 'there')
    assert load_policy(there.policy_path).knows('alice')
    import_identity(tmp_path / 'there', tmp_path / 'old')
    assert list(there.list_revoked()) == ['alice']


def test_a_file_of_another_authority_is_not_imported(keystore: Keystore, tmp_path: Path) -> None:
    other = Keystore.create(tmp_path / 'other')
    for each in (keystore, other):
        each.add('robby', 'robot', ())
        export(each, 'robby', tmp_path / f'{each.path.name}.identity')
    import_identity(tmp_path / 'there', tmp_path / 'keys.identity')
    before = (tmp_path / 'there' / 'identities' / 'robby.pem').read_bytes()
    with pytest.raises(SecurityError, match='trusts another authority'):
        import_identity(tmp_path / 'there', tmp_path / 'other.identity')
    assert (tmp_path / 'there' / 'identities' / 'robby.pem').read_bytes() == before


@pytest.mark.parametrize('content', ['', '{}', '[1]', '{"format": "goalwire identity 1"}'])
def test_a_file_that_was_not_exported_is_refused(tmp_path: Path, content: str) -> None:
    (tmp_path / 'file').write_text(content)
    with pytest.raises(SecurityError, match="is not a file that 'goalwire secure export' has written"):
        import_identity(tmp_path / 'there', tmp_path / 'file')
    assert not (tmp_path / 'there').exists()


# ---- lost power


def _run_killed_at(step: int, action: Callable[[], object]) -> bool:
    """Run something in a child that dies before its file operation number `step`; whether it died."""
    child = os.fork()
    if child == 0:
        steps = 0

        def count(event: str, _arguments: object) -> None:
            nonlocal steps
            if event == 'open' or event.startswith('os.'):
                if steps == step:
                    os._exit(9)
                steps += 1

        sys.addaudithook(count)
        try:
            action()
        finally:
            os._exit(0)
    _, status = os.waitpid(child, 0)
    return os.waitstatus_to_exitcode(status) == 9


def _problems(keystore: Keystore) -> list[str]:
    return [each.problem for each in check(keystore) if each.is_error]


@pytest.mark.slow
@pytest.mark.skipif(not hasattr(os, 'fork'), reason='forks')
def test_lost_power_at_any_step_of_init_leaves_all_or_nothing(tmp_path: Path) -> None:
    step = 0
    path = tmp_path / 'keys0'
    while _run_killed_at(step, partial(Keystore.create, path)):
        if path.exists():
            assert check(Keystore(path)) == []
        else:
            assert check(Keystore.create(path)) == []
        step += 1
        path = tmp_path / f'keys{step}'
    assert step > 10


@pytest.mark.slow
@pytest.mark.skipif(not hasattr(os, 'fork'), reason='forks')
@pytest.mark.parametrize('what', ['add', 'renew', 'revoke', 'import'])
def test_lost_power_at_any_step_leaves_a_keystore_that_works(
    keystore: Keystore, tmp_path: Path, what: str
) -> None:
    keystore.add('robby', 'robot', ())
    export(keystore, 'robby', tmp_path / 'file')
    import_identity(tmp_path / 'there', tmp_path / 'file')
    step = 0
    while True:
        name = f'new{step}'
        if what == 'revoke':
            keystore.add(name, 'person', ())
        if what == 'import':
            keystore.renew('robby')
            export(keystore, 'robby', tmp_path / name)
        actions: dict[str, Callable[[], object]] = {
            'add': lambda: keystore.add(name, 'robot', ()),  # noqa: B023
            'renew': lambda: keystore.renew('robby'),
            'revoke': lambda: keystore.revoke(name),  # noqa: B023
            'import': lambda: import_identity(tmp_path / 'there', tmp_path / name),  # noqa: B023
        }
        if not _run_killed_at(step, actions[what]):
            break
        looked_at = Keystore(tmp_path / 'there') if what == 'import' else keystore
        looked_at.identity('robby')
        left = _problems(looked_at)
        # A key that is revoked and not deleted yet is told of; that is the safe side.
        assert left in ([], [f"'{name}' is revoked"])
        if what != 'add' or name not in looked_at.names():
            actions[what]()  # and what was interrupted can be done again
        step += 1
    assert step > 3
