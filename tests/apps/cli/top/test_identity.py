"""goalwire top with an identity: it asks the policy of the robot, as every other program does."""

from __future__ import annotations

import sys
from collections.abc import Iterator

import pytest
from helpers.isolation import isolated_env
from helpers.markdown import ROOT
from helpers.processes import Program

from goalwire.security.keystore import Keystore

if sys.platform == 'win32':
    pytest.skip('terminals of POSIX', allow_module_level=True)

from helpers.screens import Screen, screen

pytestmark = [pytest.mark.slow, pytest.mark.timeout(400)]

SIZE = 130, 32
F2 = b'\x1bOQ'
ROLES = {'robby': ('robot',), 'guest': ('viewer',), 'ann': ('operator',)}


@pytest.fixture(scope='module')
def keystore(tmp_path_factory: pytest.TempPathFactory) -> Keystore:
    made = Keystore.create(tmp_path_factory.mktemp('site') / 'keys')
    for name, roles in ROLES.items():
        made.add(name, 'robot' if name == 'robby' else 'person', roles)
    return made


@pytest.fixture(scope='module')
def world(keystore: Keystore) -> Iterator[dict[str, str]]:
    """The environment of a robot that adds two integers for operators."""
    env = isolated_env('rmw_zenoh_cpp')
    robot = {**env, 'GOALWIRE_SECURITY': f'{keystore.path}:robby'}
    with Program(ROOT / 'examples' / 'add_two_ints_server.py', env=robot) as server:
        server.expect('Ready')
        yield env


def _ask_for_a_sum(shown: Screen) -> None:
    """Call the robot's only service with the form as it is."""
    shown.sees(r'\d+ nodes, \d+ topics, \d+ services')
    shown.press(b'3')
    shown.sees('(?m)^ /add_two_ints')
    shown.press(b'c')
    shown.sees('a: 0')
    shown.press(F2)
    shown.sees('y sends it; any other key goes back')
    shown.press(b'y')


def _as(name: str, world: dict[str, str], keystore: Keystore) -> dict[str, str]:
    return {**world, 'GOALWIRE_SECURITY': f'{keystore.path}:{name}'}


def test_an_operator_calls_and_a_viewer_is_refused_with_the_rule(
    world: dict[str, str], keystore: Keystore
) -> None:
    with screen(_as('ann', world, keystore), 'top', size=SIZE) as shown:
        _ask_for_a_sum(shown)
        shown.sees('/add_two_ints answered in .* ms')
    with screen(_as('guest', world, keystore), 'top', size=SIZE) as shown:
        _ask_for_a_sum(shown)
        shown.sees(r"denied: policy\.toml:\d+: none of the roles of 'guest' may call\s+'/add_two_ints'")
        assert 'Traceback' not in shown.text


def test_without_an_identity_it_shows_nothing_of_the_robot(world: dict[str, str]) -> None:
    with screen(world, 'top', size=SIZE) as shown:
        shown.expect('which speaks TLS, while this program has no security')
        shown.press(b'3')
        shown.sees(r'0 nodes, \d+ topics, 0 services')
        shown.sees('(?m)^ service +servers')
        assert 'add_two_ints' not in shown.seen
