"""The reports of a robot with a policy: refusals on /diagnostics, and in its audit log also each move."""

from __future__ import annotations

import re
from collections.abc import Iterator

import pytest
from helpers.command_line import CommandLine
from helpers.isolation import isolated_env
from helpers.patience import wait_for
from helpers.processes import Program

from goalwire.security import audit
from goalwire.security.keystore import Keystore
from goalwire.security.policy import Verb

pytestmark = pytest.mark.slow

ALL = ''.join(f'{verb.value} = ["/**"]\n' for verb in Verb)
POLICY = f"""\
[everyone]
run = ["/**"]
serve = ["/_ros2cli*/**", "/pilot/**"]
publish = ["/rosout", "/parameter_events"]
introspect = ["/**"]
[roles.robot]
{ALL}
[roles.pilot]
call = ["/reset", "/home"]
publish = ["/cmd_vel"]
send = ["/count"]
subscribe = ["/diagnostics"]
[moving]
call = ["/home"]
[identities]
robby = ["robot"]
ann = ["pilot"]
mallory = []
"""
ROBOT = """
import asyncio
from example_interfaces.action import Fibonacci
from geometry_msgs.msg import Twist
from std_srvs.srv import Trigger
import goalwire

async def main():
    async with goalwire.Node('robot') as node:
        for name in ('/reset', '/home'):
            node.service(Trigger, name, lambda _: Trigger.Response(success=True))

        async def count(goal):
            return Fibonacci.Result(sequence=[1])

        node.action_server(Fibonacci, '/count', count)
        velocities = node.subscription(Twist, '/cmd_vel')
        print('ready', flush=True)
        async for _ in velocities:
            print('moves', flush=True)

asyncio.run(main())
"""


@pytest.fixture(scope='module')
def keystore(tmp_path_factory: pytest.TempPathFactory) -> Keystore:
    made = Keystore.create(tmp_path_factory.mktemp('site') / 'keys')
    for name in ('robby', 'ann', 'mallory'):
        made.add(name, 'program', ())
    made.policy_path.write_text(POLICY)
    return made


@pytest.fixture(scope='module')
def world(keystore: Keystore) -> Iterator[tuple[Program, dict[str, str]]]:
    """The robot, and the environment of programs beside it."""
    env = isolated_env('rmw_zenoh_cpp')
    with Program(ROBOT, env={**env, 'GOALWIRE_SECURITY': f'{keystore.path}:robby'}) as robot:
        robot.expect('ready')
        yield robot, env


def _as(name: str, keystore: Keystore, env: dict[str, str]) -> CommandLine:
    return CommandLine({**env, 'GOALWIRE_SECURITY': f'{keystore.path}:{name}'})


def _wait_for_entry(keystore: Keystore, **fields: str) -> dict[str, str]:
    path = audit.log_path(keystore.path, 'robby')

    def find() -> dict[str, str] | None:
        entries = audit.read(path) if path.exists() else iter(())
        return next((each for each in entries if fields.items() <= each.items()), None)

    wait_for(find, f'an entry of the audit log with {fields}')
    found = find()
    assert found is not None
    return found


def test_refusals_are_told_on_diagnostics_and_not_before(
    world: tuple[Program, dict[str, str]], keystore: Keystore
) -> None:
    _, env = world
    ann, mallory = _as('ann', keystore, env), _as('mallory', keystore, env)
    assert '/diagnostics' not in ann.ok('topic', 'list').split()
    for _ in range(2):
        refused = mallory('service', 'call', '/reset', 'std_srvs/srv/Trigger')
        assert refused.code != 0
        assert 'denied: policy.toml' in refused.err
    told = ann.ok('topic', 'echo', '--once', '/diagnostics', 'diagnostic_msgs/msg/DiagnosticArray')
    assert "name: 'robby: refused to mallory'" in told
    message = re.search(r'message: (.*?)\n  hardware_id: robby', told, re.DOTALL)
    assert message is not None
    words = ' '.join(message[1].split())
    assert re.search(r"refused \d+ times: policy.toml:\d+: none of the roles of '+mallory'+ may call", words)
    assert re.search(r"key: call /reset\s+value: '[2-9]'", told)
    assert 'level: 1' in told or r'level: "\x01"' in told


def test_what_moves_is_in_the_log_and_what_does_not_is_not(
    world: tuple[Program, dict[str, str]], keystore: Keystore
) -> None:
    robot, env = world
    ann = _as('ann', keystore, env)
    ann.ok('service', 'call', '/reset', 'std_srvs/srv/Trigger')
    ann.ok('service', 'call', '/home', 'std_srvs/srv/Trigger')
    ann.ok('action', 'send_goal', '/count', 'example_interfaces/action/Fibonacci', '{order: 1}')
    ann.ok('topic', 'pub', '--times', '3', '--rate', '20', '-w', '1', '/cmd_vel', 'geometry_msgs/msg/Twist')
    robot.expect('moves')
    moved = {'outcome': 'moves', 'who': 'ann'}
    assert 'pilot: call /home' in _wait_for_entry(keystore, act='call', key='/home', **moved)['reason']
    assert re.fullmatch('[0-9a-f]{32}', _wait_for_entry(keystore, act='send', key='/count', **moved)['goal'])
    _wait_for_entry(keystore, act='publish', key='/cmd_vel', **moved)
    keys = [each['key'] for each in audit.read(audit.log_path(keystore.path, 'robby'))]
    assert keys.count('/cmd_vel') == 1
    assert '/reset' not in [
        each['key'] for each in audit.read(audit.log_path(keystore.path, 'robby')) if each['who'] == 'ann'
    ]
    shown = ann.ok('secure', 'audit', 'robby', '--by', 'ann', '-k', str(keystore.path))
    assert 'moves: ann: call /home' in shown
    assert 'mallory' not in shown


def test_what_counts_as_moving_changes_with_the_policy(
    world: tuple[Program, dict[str, str]], keystore: Keystore
) -> None:
    _, env = world
    ann = _as('ann', keystore, env)
    with Program(CALLER, env=ann.env) as caller:
        caller.expect('called')
        text = POLICY.replace('call = ["/home"]\n', 'call = ["/home", "/reset"]\n')
        keystore.policy_path.write_text(text)
        found = _wait_for_entry(keystore, act='call', key='/reset', outcome='moves', who='ann')
        assert found['reason'].endswith('pilot: call /reset')
        caller.expect('called')


CALLER = """
import asyncio
from std_srvs.srv import Trigger
import goalwire

async def main():
    async with goalwire.Node('pilot') as node:
        reset = node.client(Trigger, '/reset')
        async for _ in node.timer(0.1):
            await reset.call(timeout=30)
            print('called', flush=True)

asyncio.run(main())
"""
