"""ros2 version, doctor and completion."""

from __future__ import annotations

import json
import re
import shutil
import socket
import subprocess
from pathlib import Path

import pytest
from helpers.command_line import CommandLine, executable, on_dds_too
from helpers.isolation import isolated_env
from helpers.processes import Program

import goalwire
from goalwire.apps.cli.commands.doctor import noun as doctor
from goalwire.apps.cli.framework.output import Output
from goalwire.errors import TransportError
from goalwire.security.keystore import Keystore
from goalwire.transport import registry

PROGRAMS = Path(__file__).parents[1] / 'programs'


@on_dds_too
def test_version_names_goalwire_and_its_parts(ros2: CommandLine) -> None:
    out = ros2.ok('version')
    assert out == ros2.ok('--version')
    assert out.splitlines()[0] == f'goalwire {goalwire.__version__}'
    assert json.loads(ros2.ok('version', '--json'))['goalwire'] == goalwire.__version__


@on_dds_too
def test_doctor_sees_peers_and_has_two_processes_talk(ros2: CommandLine) -> None:
    out = ros2.ok('doctor')
    assert 'ok   peers: 2 nodes in 1 sessions: /_hidden, /lab/workshop\n' in out
    assert 'ok   self-test: another process answered a service call within ' in out
    assert out.endswith('all is well\n')
    checks = [json.loads(line) for line in ros2.ok('doctor', '--json', '--no-self-test').splitlines()]
    assert all(check['is_well'] for check in checks)


def test_doctor_says_if_it_answers_at_the_routers_port_itself() -> None:
    world = isolated_env('rmw_zenoh_cpp')
    free = f'ok   port {world["GOALWIRE_ROUTER_PORT"]}: free: the first program offers the rendezvous'
    out = CommandLine(world).ok('doctor', '--no-self-test')
    assert re.search(rf'^{free}; doctor does so itself while it looks \(process \d+\)$', out, re.MULTILINE)


@on_dds_too
def test_doctor_names_the_endpoints_whose_qos_does_not_go_together(
    ros2: CommandLine, world: dict[str, str]
) -> None:
    with Program(PROGRAMS / 'camera.py', env=world) as program:
        program.expect('^ready$')
        ended = ros2('doctor', '--report-failed', '--no-self-test')
    assert ended.code == 1
    assert ended.out == (
        "FAIL /image: the QoS of publisher '/camera' and subscription '/viewer' on '/image' do not go "
        'together: Best effort publisher and reliable subscription\n'
        '     give both the same\n'
    )
    assert ended.err.splitlines()[-1] == 'ros2: not well: /image; next: give both the same'


def test_doctor_does_not_call_a_wire_well_that_cannot_be_used(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    def fail(identifier: str) -> None:
        raise TransportError(f'{identifier} is not installed')

    monkeypatch.setattr(registry, 'get', fail)
    monkeypatch.setenv('RMW_IMPLEMENTATION', 'goalwire_memory')
    for check in doctor._wires():
        doctor._show(check, Output())
    out = capsys.readouterr().out
    assert '-    wire rmw_zenoh_cpp: cannot be used here, and is not selected\n' in out
    assert 'FAIL wire goalwire_memory: cannot be used (selected)\n' in out
    assert 'ok' not in out


def test_doctor_says_what_to_do_where_a_port_is_held(world: dict[str, str]) -> None:
    if world['RMW_IMPLEMENTATION'] != 'rmw_zenoh_cpp':
        pytest.skip('only Zenoh meets at a port')
    with socket.create_server(('127.0.0.1', 0)) as stranger:
        port = str(stranger.getsockname()[1])
        ended = CommandLine(world)('doctor', '--report-failed', '--no-self-test', GOALWIRE_ROUTER_PORT=port)
    assert ended.code == 1
    assert f'FAIL port {port}: ' in ended.out
    assert ended.err.splitlines()[-1].startswith(f'ros2: not well: port {port}')
    assert 'set GOALWIRE_ROUTER_PORT to a free port' in ended.err.splitlines()[-1]


@pytest.mark.slow
def test_doctor_looks_at_a_secured_programs_port_with_and_without_security(tmp_path: Path) -> None:
    world = isolated_env('rmw_zenoh_cpp')
    keystore = Keystore.create(tmp_path / 'keys')
    keystore.add('robby', 'robot', ())
    keystore.add('alice', 'person', ('operator',))
    port = world['GOALWIRE_ROUTER_PORT']
    secured = world | {'GOALWIRE_SECURITY': f'{keystore.path}:robby'}
    with Program(PROGRAMS / 'lamp.py', env=secured) as robot:
        robot.expect('^ready$')
        without = CommandLine(world)('doctor', '--report-failed', '--no-self-test')
        ours = CommandLine(world).ok('doctor', GOALWIRE_SECURITY=f'{keystore.path}:alice')
    assert f'FAIL port {port}: ' in without.out
    assert 'next: export GOALWIRE_SECURITY=KEYSTORE:NAME' in without.err.splitlines()[-1]
    assert f'port {port}: a Zenoh router with TLS answers' in ours


@pytest.mark.parametrize(
    ('words', 'found'),
    [
        (['serv'], ['service']),
        (['service', 'li'], ['list']),
        (['service', 'call', '--ti'], ['--timeout']),
        (['topic', 'echo', '/x', '--qos-durability', 'v'], ['volatile']),
        (['service', 'call', '/lab/a'], ['/lab/add']),
        (['service', 'call', '--timeout', '3', '/lab/a'], ['/lab/add']),
        (['service', 'call', '/lab/add', ''], ['example_interfaces/srv/AddTwoInts']),
        (['service', 'call', 'lab/a'], ['/lab/add']),
        (['service', 'call', '/lab/add', 'example_interfaces/srv/AddTwoInts', ''], ['a=', 'b=']),
        (['service', 'call', '/lab/add', 'example_interfaces/srv/AddTwoInts', 'a=1', ''], ['b=']),
        (
            ['topic', 'pub', '/p', 'geometry_msgs/msg/PoseStamped', 'pose.'],
            ['pose.position.', 'pose.orientation.'],
        ),
        (['action', 'send_goal', '/lab/fibonacci', 'example_interfaces/action/Fibonacci', ''], ['order=']),
        (['action', 'send_goal', ''], ['/lab/fibonacci']),
        (['node', 'info', '/'], ['/lab/workshop']),
        (['param', 'get', ''], ['/lab/workshop']),
        (['param', 'get', '/lab/workshop', 'sp'], ['speed']),
        (['param', 'set', 'lab/workshop', 'ge'], ['gears']),
        (['interface', 'show', 'std_srvs/srv/S'], ['std_srvs/srv/SetBool']),
        (['interface', 'package', 'std_s'], ['std_srvs']),
        (['completion', 'b'], ['bash']),
        (['nothing', 'at'], ['']),
    ],
)
def test_completion_knows_parsers_and_graph(ros2: CommandLine, words: list[str], found: list[str]) -> None:
    assert ros2.ok('_complete', 'zsh', *words).splitlines() == found


@pytest.mark.skipif(shutil.which('bash') is None, reason='no bash')
def test_bash_completes(world: dict[str, str]) -> None:
    script = (
        'eval "$(ros2 completion bash)"; COMP_WORDS=(ros2 inter);'
        'COMP_LINE="ros2 inter"; COMP_POINT=10; _goalwire_complete;'
        'echo "${COMPREPLY[@]}"; complete -p ros2'
    )
    env = {**world, 'PATH': f'{executable().parent}:{world["PATH"]}'}
    done = subprocess.run(['bash', '-c', script], env=env, capture_output=True, text=True, check=True)
    assert done.stdout == 'interface\ncomplete -o default -F _goalwire_complete ros2\n'


@pytest.mark.parametrize('shell', ['zsh', 'fish'])
def test_other_shells_take_their_script(shell: str, world: dict[str, str], tmp_path: Path) -> None:
    script = CommandLine(world).ok('completion', shell)
    assert '_complete' in script
    if shutil.which(shell) is None:
        pytest.skip(f'no {shell} here: its script was printed, not run')
    file = tmp_path / 'completion'
    file.write_text(script, encoding='utf-8')
    subprocess.run([shell, '-n', file], check=True)
