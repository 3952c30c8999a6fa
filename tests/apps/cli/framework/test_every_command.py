"""The behaviour of every command: help, errors, codes, pipes, Ctrl-C, the hand-over to a real ROS 2."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
from pathlib import Path
from shlex import quote

import pytest
from helpers.command_line import Begin, CommandLine, executable
from helpers.markdown import DOCS, rows

from goalwire.apps.cli.framework import nouns
from goalwire.apps.cli.framework.outcome import Outcome
from goalwire.apps.cli.framework.output import escape, json_text


@pytest.fixture(scope='module', params=['rmw_zenoh_cpp'])
def world(request: pytest.FixtureRequest) -> dict[str, str]:
    """The wire has no part in this."""
    from helpers.isolation import isolated_env

    return isolated_env(request.param)


def test_help_names_every_noun(world: dict[str, str]) -> None:
    ros2 = CommandLine(world)
    out = ros2.ok('--help')
    assert out.startswith('usage: ros2 ')
    assert all(f'  {noun} ' in out for noun in nouns.NOUNS)
    assert ros2.ok() == out
    assert ros2.ok('--help', program='goalwire').startswith('usage: goalwire ')


@pytest.mark.parametrize('name', list(nouns.NOUNS))
def test_every_noun_and_verb_has_help_of_its_own(name: str, world: dict[str, str]) -> None:
    ros2 = CommandLine(world)
    noun = nouns.load(name)
    assert (noun.name, noun.summary) == (name, nouns.NOUNS[name][1])
    out = ros2.ok(name, '-h')
    if noun.is_command:
        return
    assert ros2.ok(name) == out
    assert all(f'  {verb.name} ' in out for verb in noun.verbs)
    assert ros2.ok(name, noun.verbs[0].name, '--help').startswith(f'usage: ros2 {name} {noun.verbs[0].name}')


def test_nothing_heavy_is_imported_for_help() -> None:
    """One such import would spoil the figures that are measured in the benchmarks."""
    code = (
        'import sys; from goalwire.apps.cli.main import run_command; run_command("ros2", ["--help"]);'
        'print([name for name in sys.modules if name in {"zenoh", "numpy", "asyncio", "argparse", "yaml"}])'
    )
    done = subprocess.run([sys.executable, '-c', code], capture_output=True, text=True, check=True)
    assert done.stdout.splitlines()[-1] == '[]'


def test_a_wrong_noun_verb_or_flag_is_one_line(world: dict[str, str]) -> None:
    ros2 = CommandLine(world)
    assert ros2.fails('servise', code=2) == (
        "ros2: there is no command 'servise'; did you mean 'service' or 'secure'? see: ros2 --help"
    )
    assert ros2.fails('service', 'lst', code=2) == (
        "ros2 service: there is no verb 'lst'; did you mean 'list'? see: ros2 service --help"
    )
    assert ros2.fails('service', 'list', '--nothing', code=2) == (
        'ros2 service list: unrecognized arguments: --nothing; see: ros2 service list --help'
    )
    assert 'arguments are required: service_name' in ros2.fails('service', 'type', code=2)
    assert 'ROS_DOMAIN_ID' in ros2.fails('service', 'list', code=2, ROS_DOMAIN_ID='many')
    assert 'rmw_iceoryx_cpp' in ros2.fails('service', 'list', code=10, RMW_IMPLEMENTATION='rmw_iceoryx_cpp')


def test_what_only_ros2_has_is_told_with_what_to_use_instead(world: dict[str, str]) -> None:
    ros2 = CommandLine(world)
    assert ros2.fails('test', 'x.py', code=2) == (
        "ros2: there is no command 'test'; use 'pytest', for launch tests too"
    )
    assert ros2.fails('pkg', 'create', 'x', code=2) == (
        "ros2 pkg: there is no verb 'create'; use 'goalwire new'; see: ros2 pkg --help"
    )
    assert 'no daemon is needed here' in ros2.ok('daemon', 'stop')
    assert 'no daemon is needed here' in ros2.fails('daemon', code=2)
    assert ros2.ok('wtf', '--help') == ros2.ok('doctor', '--help')


@pytest.mark.skipif(os.name != 'posix', reason='pipes and signals of POSIX')
def test_a_closed_pipe_ends_it_without_a_word(world: dict[str, str]) -> None:
    reader, writer = os.pipe()
    os.close(reader)
    done = subprocess.run(
        [executable(), 'service', '--help'], env=world, stdout=writer, stderr=subprocess.PIPE, check=False
    )
    os.close(writer)
    assert (done.returncode, done.stderr) == (141, b'')


@pytest.mark.skipif(not Path('/dev/full').exists(), reason='/dev/full')
@pytest.mark.parametrize('variable', ['', '1'])
def test_a_full_disk_is_an_error_in_one_line(variable: str, world: dict[str, str]) -> None:
    env = {**world, 'PYTHONUNBUFFERED': variable}
    with Path('/dev/full').open('w') as full:
        command = [str(executable()), 'interface', 'list']
        done = subprocess.run(command, env=env, stdout=full, stderr=subprocess.PIPE, text=True, check=False)
        silent = subprocess.run(command, env=env, stdout=full, stderr=full, check=False)
    assert (done.returncode, done.stderr) == (1, 'ros2: [Errno 28] No space left on device\n')
    assert silent.returncode == 1


@pytest.mark.skipif(os.name != 'posix', reason='pipes and signals of POSIX')
def test_ctrl_c_ends_it_without_a_word(world: dict[str, str], begin: Begin) -> None:
    call = begin('service', 'call', '/nobody', 'std_srvs/srv/Trigger', '--timeout', '60')
    call.expect('waiting for service')
    call.send_signal(signal.SIGINT)
    assert call.wait() == 130
    assert call.output.splitlines() == ['waiting for service to become available...']


LOST_INTERRUPT = """
import os, signal, sys, time
from goalwire.apps.cli import main
from goalwire.apps.cli.framework import nouns

class Dying:
    def __del__(self):
        os.kill(os.getpid(), signal.SIGINT)
        end = time.monotonic() + 20
        while time.monotonic() < end:
            pass

def load(name, real=nouns.load):
    Dying()  # as what dies during an import
    return real(name)

nouns.load = load
signal.signal(signal.SIGINT, signal.default_int_handler)  # whatever who runs the tests does with it
sys.argv = ['ros2', 'version']
sys.exit(main.main())
"""


@pytest.mark.skipif(os.name != 'posix', reason='signals of POSIX')
def test_ctrl_c_during_an_import_is_not_lost(world: dict[str, str]) -> None:
    done = subprocess.run(
        [sys.executable, '-c', LOST_INTERRUPT], env=world, capture_output=True, text=True, check=False
    )
    assert (done.returncode, done.stdout, done.stderr) == (130, '', '')


def test_the_page_names_every_exit_code() -> None:
    page = DOCS / 'reference' / 'command-line.md'
    table = {name.strip('`'): int(code) for code, name, *_ in rows(page, 'code')}
    assert table == {outcome.name: outcome.value for outcome in Outcome}


def test_what_peers_send_reaches_no_terminal_unescaped() -> None:
    assert escape('a\x1b[31m\tb\nc\x07\x9b') == 'a\\x1b[31m\tb\nc\\x07\\x9b'
    assert escape('\u202egro.elpmaxe') == '\\u202egro.elpmaxe'
    assert json_text({'a': '\x9b\x1b', 'b': [float('nan'), float('-inf')]}) == (
        '{"a": "\\u009b\\u001b", "b": ["NaN", "-Infinity"]}'
    )


@pytest.mark.skipif(os.name != 'posix', reason='the real one is a script')
def test_ros2_hands_over_to_the_one_that_is_sourced(world: dict[str, str], tmp_path: Path) -> None:
    real = tmp_path / 'bin' / 'ros2'
    real.parent.mkdir()
    real.write_text('#!/bin/sh\necho the real one: "$@"\nexit 7\n', encoding='utf-8')
    real.chmod(0o755)
    ros2 = CommandLine({**world, 'AMENT_PREFIX_PATH': f'{tmp_path / "workspace"}:{tmp_path}'})
    ended = ros2('service', 'list', '--x y')
    assert (ended.code, ended.out) == (7, 'the real one: service list --x y\n')
    assert ros2('--help', program='goalwire').out.startswith('usage: goalwire')
    assert ros2('--help', GOALWIRE_FIRST='1').out.startswith('usage: ros2 ')
    comes_back = f'#!/bin/sh\nexec {quote(str(executable()))} "$@"\n'
    real.write_text(comes_back, encoding='utf-8')
    assert ros2('--help').out.startswith('usage: ros2 ')
