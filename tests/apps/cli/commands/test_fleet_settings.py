"""goalwire fleet init and join: which settings they write, and which identities they refuse."""

from __future__ import annotations

import json
import shutil
from pathlib import Path
from typing import cast

import pytest
from helpers.command_line import CommandLine, Ended
from helpers.forking import ForkServer
from helpers.isolation import isolated_env

from goalwire.security.keystore import Keystore

MAKE_A_ROUTER = 'see: goalwire secure add NAME --router, or: goalwire fleet join alpha'
WRITE_A_ROUTER = 'see: goalwire fleet init cloud --router ADDRESS'
JOIN = 'join alpha --router site.example.org'


class Desk:
    """The folder of somebody who sets up a fleet: keystore `keys`, a cloud, a site, two robots and Ann."""

    def __init__(self, folder: Path, commands: ForkServer) -> None:
        self.folder = folder
        self._line = CommandLine(isolated_env('rmw_zenoh_cpp'), folder, commands)
        self.keystore = Keystore.create(folder / 'keys')
        kinds = {'cloud': 'router', 'site': 'router', 'alpha': 'robot', 'beta': 'robot', 'ann': 'person'}
        for name, kind in kinds.items():
            self.keystore.add(name, kind, ())

    def __call__(self, line: str, keys: str = 'keys') -> Ended:
        return self._line('fleet', *line.split(), '-k', keys, program='goalwire')

    def write(self, line: str, file: str, keys: str = 'keys') -> dict[str, object]:
        """Run a command that writes settings, and return them."""
        ended = self(line, keys)
        assert (ended.code, ended.err) == (0, '')
        assert ended.out.startswith(f'{file} is written; next: ')
        settings = json.loads((self.folder / file).read_text(encoding='utf-8'))
        assert isinstance(settings, dict)
        return settings

    def refuses(self, line: str, code: int, keys: str = 'keys') -> str:
        """Run a command that writes nothing, and return its only line on stderr."""
        before = {each: each.read_bytes() for each in self.folder.rglob('*.json5')}
        ended = self(line, keys)
        assert (ended.code, ended.out, ended.err.count('\n')) == (code, '', 1), ended
        assert {each: each.read_bytes() for each in self.folder.rglob('*.json5')} == before
        return ended.err.removeprefix('goalwire: ').rstrip('\n')


@pytest.fixture
def desk(tmp_path: Path, commands: ForkServer) -> Desk:
    return Desk(tmp_path, commands)


def _endpoints(settings: dict[str, object], side: str) -> object:
    found = settings[side]
    assert isinstance(found, dict)
    return found['endpoints']


def _subjects(settings: dict[str, object]) -> dict[str, object]:
    """Return the certificates that may connect, by the names of their subjects."""
    access = settings['access_control']
    assert isinstance(access, dict)
    assert (access['enabled'], access['default_permission']) == (True, 'deny')
    return {each['id']: each.get('cert_common_names') for each in access['subjects']}


def test_the_router_of_a_site_dials_the_cloud_and_knows_each_robot(desk: Desk) -> None:
    settings = desk.write('init site --router cloud.example.org', 'site.json5')
    assert settings['mode'] == 'router'
    assert _endpoints(settings, 'connect') == ['tls/cloud.example.org:7447']
    assert _subjects(settings) == {'alpha': ['alpha'], 'beta': ['beta'], 'others': ['ann', 'cloud']}


def test_a_cloud_dials_nobody_and_listens_where_it_is_told(desk: Desk) -> None:
    settings = desk.write('init cloud --listen 10.0.0.1 --listen [::1]:7500 -o sky', 'sky')
    assert _endpoints(settings, 'connect') == []
    assert _endpoints(settings, 'listen') == ['tls/10.0.0.1:7447', 'tls/[::1]:7500']


def test_a_fleet_whose_keys_may_not_fit_on_a_link_is_told_what_to_do(desk: Desk) -> None:
    alpha = desk.keystore.identity_path('alpha')
    for number in range(594):
        shutil.copy(alpha, alpha.with_name(f'r{number}.pem'))
    ended = desk('init cloud')
    assert (ended.code, ended.out.partition(';')[0]) == (0, 'cloud.json5 is written')
    assert ended.err.startswith('596 robots: a link between routers carries 65,535 keys')
    assert ended.err.endswith('goalwire fleet join ROBOT --allow NAME\n')


def test_the_router_of_a_robot_keeps_its_programs_on_its_machine(desk: Desk) -> None:
    settings = desk.write(f'{JOIN} --port 7460 --keys-there /etc/keys --rate camera/image=2', 'alpha.json5')
    assert _endpoints(settings, 'listen') == ['tcp/127.0.0.1:7460']
    assert _endpoints(settings, 'connect') == ['tls/site.example.org:7447']
    assert '/etc/keys/identities/alpha.pem' in json.dumps(settings['transport'])
    [downsampling] = cast('list[dict[str, object]]', settings['downsampling'])
    assert downsampling['rules'] == [{'key_expr': '*/alpha/camera/image/**', 'freq': 2.0}]


def test_a_person_gets_the_settings_of_a_session(desk: Desk) -> None:
    settings = desk.write('join ann --router cloud.example.org', 'ann.json5')
    assert settings['mode'] == 'client'
    assert _endpoints(settings, 'connect') == ['tls/cloud.example.org:7447']


def test_settings_that_are_there_are_replaced_on_request_alone(desk: Desk) -> None:
    """For a cloud that has got a new robot they must be written again."""
    desk.write('init cloud', 'cloud.json5')
    desk.write(JOIN, 'alpha.json5')
    assert desk.refuses('init cloud', 7) == "the file 'cloud.json5' is there already; replace it with --force"
    assert desk.refuses(JOIN, 7) == "the file 'alpha.json5' is there already; replace it with --force"
    desk.keystore.add('gamma', 'robot', ())
    desk.keystore.revoke('beta')
    subjects = _subjects(desk.write('init cloud --force', 'cloud.json5'))
    assert list(subjects) == ['alpha', 'gamma', 'others']


@pytest.mark.parametrize(
    ('line', 'code', 'says'),
    [
        ('init alpha', 4, f"'alpha' is a robot, and not a router; {MAKE_A_ROUTER}"),
        (
            'join cloud --router x',
            4,
            f"'cloud' is a router, and not a robot or an operator; {WRITE_A_ROUTER}",
        ),
        ('init nobody', 1, "there is no identity 'nobody' in 'keys'; see: secure list"),
        ('join nobody --router x', 1, "there is no identity 'nobody' in 'keys'; see: secure list"),
        ('join ../alpha --router x', 1, "'../alpha' cannot be an identity's name"),
        (f'{JOIN} -o nowhere/alpha.json5', 1, "'nowhere/alpha.json5' cannot be written: No such file"),
    ],
)
def test_a_wrong_name_is_told_and_nothing_is_written(desk: Desk, line: str, code: int, says: str) -> None:
    assert desk.refuses(line, code).startswith(says)


@pytest.mark.parametrize(
    ('line', 'says'),
    [
        ('join alpha', 'the following arguments are required: --router'),
        ('join alpha --router udp/site', "'udp/site' is not the address of a router"),
        ('init site --router site:', "'site:' is not the address of a router"),
        ('init site --router site:seven', "'site:seven' is not the address of a router"),
        ('init site --router site:70000', "'site:70000' is not the address of a router"),
        ('init site --listen ::1', "'::1' is not the address of a router"),
        (f'{JOIN} --rate camera/image', "'camera/image' is not a topic and its rate in Hz"),
        (f'{JOIN} --rate camera/image=0', "'camera/image=0' is not a topic and its rate in Hz"),
        (f'{JOIN} --allow camera/$', "'camera/$' is not a name on the robot"),
    ],
)
def test_a_wrong_argument_is_told_and_nothing_is_written(desk: Desk, line: str, says: str) -> None:
    assert says in desk.refuses(line, 2)


def test_a_name_that_is_no_namespace_is_no_robot(desk: Desk) -> None:
    desk.keystore.add('alpha-2', 'robot', ())
    assert desk.refuses('join alpha-2 --router x', 4).endswith('name the robot as its namespace is named')


def test_a_robot_joins_with_the_identity_that_it_was_sent(desk: Desk) -> None:
    line = desk._line
    line.ok('secure', 'export', 'alpha', '-k', 'keys', program='goalwire')
    line.ok('secure', 'import', 'alpha.identity', 'there', program='goalwire')
    settings = desk.write(JOIN, 'alpha.json5', 'there')
    assert str(desk.folder / 'there' / 'identities' / 'alpha.pem') in json.dumps(settings['transport'])


def test_a_broken_export_makes_no_keystore_to_join_with(desk: Desk) -> None:
    line = desk._line
    line.ok('secure', 'export', 'alpha', '-k', 'keys', program='goalwire')
    export = desk.folder / 'alpha.identity'
    export.write_bytes(export.read_bytes()[:300])
    ended = line('secure', 'import', 'alpha.identity', 'there', program='goalwire')
    says = "goalwire: 'alpha.identity' is not a file that 'goalwire secure export' has written\n"
    assert (ended.code, ended.err) == (1, says)
    assert desk.refuses(JOIN, 1, 'there').startswith("'there' is not a keystore")


@pytest.mark.parametrize('broken', [b'', b'rubbish\n', None])
def test_a_broken_identity_is_told_by_its_file(desk: Desk, broken: bytes | None) -> None:
    """As a copy that was cut off leaves it."""
    shutil.copytree(desk.folder / 'keys', desk.folder / 'there')
    file = desk.folder / 'there' / 'identities' / 'alpha.pem'
    file.write_bytes(file.read_bytes()[:200] if broken is None else broken)
    says = "'there/identities/alpha.pem' holds no certificate with its key"
    assert desk.refuses(JOIN, 1, 'there').startswith(says)
