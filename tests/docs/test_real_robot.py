"""The set-ups of docs/how-to/real-robot.md, word for word, between two machines; goalwire plays the robot.

The robot's router is a Zenoh router with rmw_zenohd's own settings.
"""

from __future__ import annotations

import re
import shlex
from collections.abc import Iterator
from pathlib import Path

import pytest
from helpers.isolation import isolated_env
from helpers.machines import Machine, can_make_machines, two_machines
from helpers.markdown import DOCS, ROOT, blocks
from helpers.processes import Program

pytestmark = [
    pytest.mark.slow,
    pytest.mark.skipif(not can_make_machines(), reason='needs Linux, root and `ip` for network namespaces'),
]

PAGE = DOCS / 'how-to' / 'real-robot.md'
EXAMPLES = ROOT / 'examples'
ROUTER_SETTINGS = ROOT / 'tests' / 'data' / 'zenoh' / 'router.json5'
ROUTER = """\
import sys, threading, zenoh
with zenoh.open(zenoh.Config.from_file(sys.argv[1])):
    print('routing', flush=True)
    threading.Event().wait()
"""


def _exported(name: str) -> str:
    """The value that the page gives to a variable."""
    text = '\n'.join(block.text for block in blocks(PAGE) if block.language == 'sh')
    [value] = re.findall(rf'^export {name}=(.*)$', text, re.MULTILINE)
    return shlex.split(value, comments=True)[0]


@pytest.fixture
def env() -> dict[str, str]:
    """A clean environment with the default port, as users have it: each machine has its own."""
    whole = isolated_env('rmw_zenoh_cpp')
    del whole['GOALWIRE_ROUTER_PORT']
    return whole


@pytest.fixture
def machines() -> Iterator[tuple[Machine, Machine]]:
    """The robot, at the page's address, and our machine."""
    with two_machines('192.168.0.7', '192.168.0.8') as pair:
        yield pair


@pytest.fixture
def robot(machines: tuple[Machine, Machine], env: dict[str, str], tmp_path: Path) -> Iterator[Machine]:
    """A robot with a router, a service and an action, under stock settings."""
    (tmp_path / 'routing.py').write_text(ROUTER, encoding='utf-8')
    machine, quiet = machines[0], {**env, 'GOALWIRE_ROUTER': 'off'}
    with machine.run(tmp_path / 'routing.py', str(ROUTER_SETTINGS), env=env) as router:
        router.expect('routing')
        with (
            machine.run(EXAMPLES / 'add_two_ints_server.py', env=quiet) as adder,
            machine.run(EXAMPLES / 'fibonacci_action_server.py', env=quiet) as counter,
        ):
            adder.expect('Ready')
            counter.expect('Ready')
            yield machine


def _ask(machine: Machine, env: dict[str, str], cwd: Path) -> Program:
    return machine.run(EXAMPLES / 'add_two_ints_client.py', '2', '3', env=env, cwd=cwd)


def test_one_program_calls_the_robots_service_and_action(
    robot: Machine, machines: tuple[Machine, Machine], env: dict[str, str], tmp_path: Path
) -> None:
    env['ZENOH_CONFIG_OVERRIDE'] = _exported('ZENOH_CONFIG_OVERRIDE')
    assert robot.address in env['ZENOH_CONFIG_OVERRIDE']
    with _ask(machines[1], env, tmp_path) as client:
        assert client.succeed().endswith('2 + 3 = 5')
    with machines[1].run(EXAMPLES / 'fibonacci_action_client.py', '3', env=env) as client:
        assert client.succeed().endswith('The goal succeeded')


def test_without_client_mode_no_call_is_answered(
    robot: Machine, machines: tuple[Machine, Machine], env: dict[str, str], tmp_path: Path
) -> None:
    env['ZENOH_CONFIG_OVERRIDE'] = _exported('ZENOH_CONFIG_OVERRIDE').replace('mode="client";', '')
    assert robot.address in env['ZENOH_CONFIG_OVERRIDE']
    with _ask(machines[1], env, tmp_path) as client:
        assert client.wait() == 1


def test_the_machines_own_rendezvous_leads_to_the_robot(
    robot: Machine, machines: tuple[Machine, Machine], env: dict[str, str], tmp_path: Path
) -> None:
    [block] = [block for block in blocks(PAGE) if block.title]
    assert robot.address in block.text
    (tmp_path / block.title).write_text(block.text, encoding='utf-8')
    env['ZENOH_ROUTER_CONFIG_URI'] = _exported('ZENOH_ROUTER_CONFIG_URI').replace('$PWD', str(tmp_path))
    with _ask(machines[1], env, tmp_path) as client:
        assert client.succeed().endswith('2 + 3 = 5')


def test_a_robot_without_ros_opens_its_rendezvous(
    machines: tuple[Machine, Machine], env: dict[str, str], tmp_path: Path
) -> None:
    [block] = [block for block in blocks(PAGE) if block.title]
    text = re.sub(r'^ *connect:.*\n', '', block.text, flags=re.MULTILINE).replace('127.0.0.1', '0.0.0.0')
    (tmp_path / 'open.json5').write_text(text, encoding='utf-8')
    server_env = {**env, 'ZENOH_ROUTER_CONFIG_URI': str(tmp_path / 'open.json5')}
    env['ZENOH_CONFIG_OVERRIDE'] = _exported('ZENOH_CONFIG_OVERRIDE')
    with machines[0].run(EXAMPLES / 'add_two_ints_server.py', env=server_env) as server:
        server.expect('Ready')
        with _ask(machines[1], env, tmp_path) as client:
            assert client.succeed().endswith('2 + 3 = 5')
