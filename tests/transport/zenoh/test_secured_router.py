"""A router with a policy, between stock sessions of eclipse-zenoh with rmw_zenoh's keys, which check nothing.

`tests/security/attacks.py` tries each verb by way of a router; here is the rest.
"""

from __future__ import annotations

import json
from collections.abc import Iterator
from contextlib import ExitStack
from datetime import timedelta
from pathlib import Path
from typing import Any

import pytest
import zenoh
from helpers.command_line import CommandLine
from helpers.isolation import free_port, isolated_env
from helpers.patience import wait_for
from helpers.secured_site import SERVICES, TOPIC, key_of

from goalwire.security.environment import Chosen
from goalwire.security.keystore import Keystore
from goalwire.security.policy import Verb
from goalwire.security.policy_file import load_policy, read_policy
from goalwire.transport.zenoh.router import router
from goalwire.transport.zenoh.router_rules import inexpressible

pytestmark = pytest.mark.slow


OPEN = key_of('/open')
EVERYONE = '[everyone]\npublish = ["/open"]\nsubscribe = ["/open"]\n'
ROBOT = '[roles.robot]\n' + ''.join(f'{verb.value} = ["/**"]\n' for verb in Verb)


def _policy(*verbs: Verb, pattern: str = '/secret') -> str:
    role = '[roles.mallory]\n' + ''.join(f'{verb.value} = ["{pattern}"]\n' for verb in verbs)
    return f'{EVERYONE}{ROBOT}{role}[identities]\nsite = []\nrobby = ["robot"]\nmallory = ["mallory"]\n'


class Site:
    """A router with a policy, and stock clients of it."""

    def __init__(self, folder: Path, stack: ExitStack) -> None:
        self.keystore = Keystore.create(folder / 'keys')
        for name in ('site', 'robby', 'mallory'):
            self.keystore.add(name, 'router' if name == 'site' else 'robot', ())
        self._stack = stack
        self._port = free_port()

    def start(self, policy: str) -> None:
        """Start the router."""
        self.keystore.policy_path.write_text(policy)
        self._stack.enter_context(router(self._port, [], [], Chosen(self.keystore.path, 'site')))

    def start_printed(self, policy: str, folder: Path) -> None:
        """Start a stock router of eclipse-zenoh with the file that `goalwire secure config` prints."""
        self.keystore.policy_path.write_text(policy)
        line = CommandLine(isolated_env('rmw_zenoh_cpp'), folder)
        keys = str(self.keystore.path)
        printed = line.ok('secure', 'config', 'router', 'site', '-k', keys, '--port', str(self._port))
        (folder / 'router.json5').write_text(printed)
        config = zenoh.Config.from_file(str(folder / 'router.json5'))
        self._stack.enter_context(zenoh.open(config))

    def client(self, name: str, **tls: Any) -> zenoh.Session:
        """Connect with an identity's certificate. Raises zenoh.ZError."""
        own = str(self.keystore.identity_path(name))
        settings = {
            'root_ca_certificate': str(self.keystore.trust_path),
            'enable_mtls': True,
            'connect_certificate': own,
            'connect_private_key': own,
            'verify_name_on_connect': False,
            **tls,
        }
        config = zenoh.Config.from_json5(
            json.dumps(
                {
                    'mode': 'client',
                    'connect': {'endpoints': [f'tls/127.0.0.1:{self._port}'], 'timeout_ms': 2000},
                    'scouting': {'multicast': {'enabled': False}},
                    'transport': {'link': {'tls': settings}},
                }
            )
        )
        return self._stack.enter_context(zenoh.open(config))


@pytest.fixture
def site(tmp_path: Path) -> Iterator[Site]:
    with ExitStack() as stack:
        yield Site(tmp_path, stack)


def _heard(sender: zenoh.Session, receiver: zenoh.Session, key: str) -> bool:
    """Whether what one puts comes to the other; both may use OPEN, which shows that the way is there."""
    got: list[str] = []
    with (
        receiver.declare_subscriber(key, lambda sample: got.append(str(sample.key_expr))),
        receiver.declare_subscriber(OPEN, lambda sample: got.append(str(sample.key_expr))),
    ):

        def comes_through() -> bool:
            sender.put(key, b'x')
            sender.put(OPEN, b'x')
            return got.count(OPEN) > 10  # a router that is busy drops some

        wait_for(comes_through)
    return key in got


def _answered(asker: zenoh.Session, answerer: zenoh.Session, key: str) -> bool:
    with answerer.declare_queryable(key, lambda query: query.reply(query.key_expr, b'done'), complete=True):
        assert _heard(answerer, asker, OPEN)  # what was declared before has come to the router
        return any(reply.ok is not None for reply in asker.get(key, timeout=2.0))


@pytest.mark.parametrize(
    'granted', [(), (Verb.PUBLISH, Verb.CALL, Verb.SET), (Verb.SUBSCRIBE, Verb.SEND, Verb.CANCEL)], ids=str
)
def test_a_stock_router_with_the_printed_file_keeps_the_policy(
    site: Site, tmp_path: Path, granted: tuple[Verb, ...]
) -> None:
    site.start_printed(_policy(*granted), tmp_path)
    mallory, robot = site.client('mallory'), site.client('robby')
    policy = load_policy(site.keystore.policy_path)
    found = {
        Verb.PUBLISH: _heard(mallory, robot, TOPIC),
        Verb.SUBSCRIBE: _heard(robot, mallory, TOPIC),
        **{verb: _answered(mallory, robot, key) for verb, key in SERVICES.items()},
    }
    assert found == {verb: policy.decide('mallory', verb, '/secret').is_allowed for verb in found}


@pytest.mark.parametrize('verb', [Verb.CANCEL, Verb.READ, Verb.SET], ids=lambda verb: verb.value)
def test_calling_everything_reaches_no_parameters_and_cancels_no_goals(site: Site, verb: Verb) -> None:
    site.start(_policy(Verb.CALL, pattern='/**'))
    mallory, robot = site.client('mallory'), site.client('robby')
    assert _answered(mallory, robot, SERVICES[Verb.CALL])
    assert not _answered(mallory, robot, SERVICES[verb])


def test_what_a_router_cannot_express_is_told() -> None:
    (told, _) = inexpressible(
        read_policy(_policy(Verb.CALL, Verb.SET).replace('call = ["/s', 'call = ["/**", "/s'))
    )
    assert told.startswith("a router refuses 'mallory' to set by way of /set_parameters")
    assert inexpressible(read_policy(_policy(Verb.SET))) == []


def test_a_stranger_gets_no_link(site: Site) -> None:
    site.start(_policy(*Verb))
    site.client('mallory')
    with pytest.raises(zenoh.ZError):
        site.client('mallory', enable_mtls=False, connect_certificate=None, connect_private_key=None)
    site.keystore.identity_path('mallory').unlink()
    site.keystore.issue('mallory', 'program', timedelta(seconds=-1))
    with pytest.raises(zenoh.ZError):
        site.client('mallory')


def test_a_revoked_identity_may_do_nothing(site: Site, tmp_path: Path) -> None:
    stolen = site.keystore.identity_path('mallory').read_bytes()
    site.keystore.revoke('mallory')
    site.start(_policy(*Verb))
    site.keystore.identity_path('mallory').write_bytes(stolen)
    mallory, robot = site.client('mallory'), site.client('robby')
    got: list[object] = []
    with robot.declare_subscriber(TOPIC, got.append):
        mallory.put(TOPIC, b'x')
        assert _heard(robot, robot, OPEN)
    assert not any(reply.ok for reply in mallory.liveliness().get('@ros2_lv/**', timeout=1.0))
    assert got == []
