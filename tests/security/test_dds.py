"""A policy as DDS Security's permissions: a reader of such documents must say what the policy says."""

from __future__ import annotations

import shutil
import stat
import subprocess
from fnmatch import fnmatchcase
from pathlib import Path
from random import Random
from typing import NamedTuple
from xml.etree import ElementTree as ET

import pytest
from cryptography import x509

from goalwire.security.certificates import now
from goalwire.security.dds_keystore import write_dds_keystore
from goalwire.security.dds_permissions import governance_xml, inexpressible, permissions_xml
from goalwire.security.keystore import Keystore
from goalwire.security.policy import Verb
from goalwire.security.policy_file import read_policy

PATTERNS = ['/**', '/arm/**', '/arm', '/arm/lift', '/base/move', '/arm/get_parameters', '/base/**']
NAMES = ['/arm', '/arm/lift', '/base/move', '/base', '/arm/hand/close']
TOPICS_OF = {
    Verb.PUBLISH: ('publish', 'rt{}'),
    Verb.SUBSCRIBE: ('subscribe', 'rt{}'),
    Verb.CALL: ('publish', 'rq{}Request'),
    Verb.SERVE: ('publish', 'rr{}Reply'),
    Verb.SEND: ('publish', 'rq{}/_action/send_goalRequest'),
    Verb.CANCEL: ('publish', 'rq{}/_action/cancel_goalRequest'),
    Verb.READ: ('publish', 'rq{}/get_parametersRequest'),
    Verb.SET: ('publish', 'rq{}/set_parametersRequest'),
}
"""The topic by which a DDS plugin knows an act: its direction, and its name."""


class Document(NamedTuple):
    """A permissions document, as a plugin reads it: the first rule that matches decides."""

    grant: ET.Element

    @classmethod
    def of(cls, text: bytes) -> Document:
        found = ET.fromstring(text).find('permissions/grant')
        assert found is not None
        return cls(found)

    def allows(self, direction: str, topic: str, domain: int) -> bool:
        for rule in self.grant:
            if rule.tag in {'allow_rule', 'deny_rule'} and _holds_in(rule, domain):
                topics = [each.text or '' for each in rule.iterfind(f'{direction}/topics/topic')]
                if any(fnmatchcase(topic, each) for each in topics):
                    return rule.tag == 'allow_rule'
        return self.grant.findtext('default') == 'ALLOW'


def _holds_in(rule: ET.Element, domain: int) -> bool:
    ids = [int(each.text or '') for each in rule.iterfind('domains/id')]
    ranges = [
        range(int(each.findtext('min', '')), int(each.findtext('max', '')) + 1)
        for each in rule.iterfind('domains/id_range')
    ]
    return domain in ids or any(domain in each for each in ranges)


def test_policies_mean_the_same_on_dds() -> None:
    random = Random(7)
    asked = allowed = 0
    for _ in range(300):
        lines = [f'domains = [{random.choice((0, 1))}]'] if random.random() < 0.3 else []
        for verb in random.sample(list(TOPICS_OF), random.randint(1, 5)):
            patterns = random.sample(PATTERNS, random.randint(1, 2))
            lines.append(f'{verb.value} = [{", ".join(map(repr, patterns))}]')
        policy = read_policy('[roles.a]\n' + '\n'.join(lines) + '\n[identities]\nann = ["a"]\n')
        assert inexpressible(policy) == []
        document = Document.of(permissions_xml('CN=/ann', policy.grants['ann'], (now(), now())))
        for verb, (direction, form) in TOPICS_OF.items():
            for name in NAMES:
                for domain in (0, 1):
                    wanted = policy.decide('ann', verb, name, domain).is_allowed
                    found = document.allows(direction, form.format(name), domain)
                    assert found == wanted, (lines, verb, name, domain)
                    asked, allowed = asked + 1, allowed + wanted
    assert asked / 10 < allowed < asked


def test_calling_everything_reaches_no_parameters_and_no_goals() -> None:
    policy = read_policy(
        '[roles.a]\ncall = ["/**"]\nsubscribe = ["/**"]\nread = ["/arm"]\n[identities]\nann = ["a"]\n'
    )
    document = Document.of(permissions_xml('CN=/ann', policy.grants['ann'], (now(), now())))
    assert document.allows('publish', 'rq/resetRequest', 0)
    assert document.allows('publish', 'rq/arm/get_parametersRequest', 0)
    assert not document.allows('publish', 'rq/base/get_parametersRequest', 0)
    assert not document.allows('publish', 'rq/walk/_action/send_goalRequest', 0)
    assert not document.allows('subscribe', 'rt/walk/_action/feedback', 0)
    assert document.allows('publish', 'ros_discovery_info', 3)


def test_a_pattern_that_grows_on_dds_is_told() -> None:
    policy = read_policy('[roles.a]\ncall = ["/*/reset", "/arm/**"]\n[identities]\nann = ["a"]\n')
    assert inexpressible(policy) == [
        "DDS lets 'ann' call more than /*/reset: its '*' also stands for slashes"
    ]


@pytest.fixture
def keystore(tmp_path: Path) -> Keystore:
    made = Keystore.create(tmp_path / 'keys')
    made.add('robot.arm', 'robot', ())
    made.add('site', 'router', ())
    return made


def test_each_identity_has_an_enclave_with_all_that_rcl_looks_for(keystore: Keystore, tmp_path: Path) -> None:
    assert write_dds_keystore(keystore, tmp_path / 'ros') == ['/robot/arm']
    place = tmp_path / 'ros' / 'enclaves' / 'robot' / 'arm'
    assert {each.name for each in place.iterdir()} >= {
        'cert.pem',
        'governance.p7s',
        'identity_ca.cert.pem',
        'key.pem',
        'permissions.p7s',
        'permissions_ca.cert.pem',
    }
    certificate, authority = (
        x509.load_pem_x509_certificate((place / name).read_bytes())
        for name in ('cert.pem', 'identity_ca.cert.pem')
    )
    certificate.verify_directly_issued_by(authority)
    authority.verify_directly_issued_by(authority)
    assert certificate.subject.rfc4514_string() == 'CN=/robot/arm'
    assert certificate.public_key() == keystore.identity('robot.arm').key.public_key()
    assert stat.S_IMODE((place / 'key.pem').stat().st_mode) == 0o600
    assert write_dds_keystore(keystore, tmp_path / 'ros') == ['/robot/arm']
    again = x509.load_pem_x509_certificate((place / 'identity_ca.cert.pem').read_bytes())
    assert again == authority


@pytest.mark.skipif(shutil.which('openssl') is None, reason='needs the program openssl')
@pytest.mark.parametrize('document', ['governance', 'permissions'])
def test_openssl_accepts_the_signature_and_no_changed_text(
    keystore: Keystore, tmp_path: Path, document: str
) -> None:
    write_dds_keystore(keystore, tmp_path / 'ros')
    place = tmp_path / 'ros' / 'enclaves' / 'robot' / 'arm'
    signed = place / f'{document}.p7s'

    def verify() -> subprocess.CompletedProcess[bytes]:
        authority = place / 'permissions_ca.cert.pem'
        return subprocess.run(
            ['openssl', 'smime', '-verify', '-text', '-in', signed, '-CAfile', authority],
            capture_output=True,
            check=False,
        )

    done = verify()
    assert done.returncode == 0, done.stderr
    assert done.stdout.replace(b'\r\n', b'\n') == (place / f'{document}.xml').read_bytes()
    signed.write_bytes(signed.read_bytes().replace(b'<min>0</min>', b'<min>1</min>', 1))
    assert verify().returncode != 0


def test_governance_lets_in_nobody_without_a_certificate() -> None:
    rule = ET.fromstring(governance_xml()).find('domain_access_rules/domain_rule')
    assert rule is not None
    assert rule.findtext('allow_unauthenticated_participants') == 'false'
    assert rule.findtext('enable_join_access_control') == 'true'
    assert rule.findtext('topic_access_rules/topic_rule/topic_expression') == '*'


def test_a_carried_keystore_makes_no_enclaves(keystore: Keystore, tmp_path: Path) -> None:
    (keystore.path / 'site.pem').unlink()
    with pytest.raises(Exception, match='has no authority that could sign'):
        write_dds_keystore(keystore, tmp_path / 'ros')
