"""The ten lines of docs/how-to/security.md, word for word, between two machines; and a stranger."""

from __future__ import annotations

import re
import shlex
from collections.abc import Iterator
from pathlib import Path
from time import monotonic

import pytest
from helpers.command_line import executable
from helpers.isolation import isolated_env
from helpers.machines import Machine, can_make_machines, two_machines
from helpers.markdown import DOCS, ROOT, blocks
from helpers.processes import Program

pytestmark = [
    pytest.mark.slow,
    pytest.mark.skipif(not can_make_machines(), reason='needs Linux, root and `ip` for network namespaces'),
]

PAGE = DOCS / 'how-to' / 'security.md'
SERVER = ROOT / 'examples' / 'add_two_ints_server.py'
_, ON_THE_ROBOT, ON_THE_LAPTOP = [block.text for block in blocks(PAGE) if block.language == 'sh'][:3]
LIST, CALL = ON_THE_LAPTOP.splitlines()[-2:]


class Shell:
    """A person who types on a machine."""

    def __init__(self, machine: Machine, env: dict[str, str], folder: Path) -> None:
        self._machine = machine
        self.env = dict(env)
        self._folder = folder
        folder.mkdir()

    def start(self, line: str) -> Program:
        """Start a command."""
        program, *arguments = shlex.split(line, comments=True)
        return self._machine.run(executable(program), *arguments, env=self.env, cwd=self._folder)

    def type(self, line: str) -> str:
        """Type a line and return what it prints; it succeeds."""
        if line.startswith('export '):
            name, _, value = shlex.split(line, comments=True)[1].partition('=')
            self.env[name] = value.replace('$PWD', str(self._folder))
            return ''
        with self.start(line) as program:
            return program.succeed()


@pytest.fixture
def machines() -> Iterator[tuple[Machine, Machine]]:
    with two_machines('192.168.0.7', '192.168.0.8') as pair:
        yield pair


@pytest.fixture
def env() -> dict[str, str]:
    """A clean environment with the default port, as users have it."""
    whole = isolated_env('rmw_zenoh_cpp')
    del whole['GOALWIRE_ROUTER_PORT']
    return whole


def test_the_laptop_works_and_a_stranger_sees_nothing(
    machines: tuple[Machine, Machine], env: dict[str, str], tmp_path: Path
) -> None:
    begin = monotonic()
    robot = Shell(machines[0], env, tmp_path / 'robot')
    laptop = Shell(machines[1], env, tmp_path / 'laptop')
    assert len((ON_THE_ROBOT + ON_THE_LAPTOP).splitlines()) == 10
    for line in ON_THE_ROBOT.splitlines():
        robot.type(line)
    (tmp_path / 'robot' / 'laptop.identity').rename(tmp_path / 'laptop' / 'laptop.identity')
    with machines[0].run(SERVER, env=robot.env) as server:
        server.expect('Ready')
        *_, listed, called = [laptop.type(line) for line in ON_THE_LAPTOP.splitlines()]
        assert '/add_two_ints_server' in listed
        assert 'sum=5' in called
        assert monotonic() - begin < 60

        where = re.search(r'tls/([\d.:]+)', ON_THE_LAPTOP)
        assert where is not None
        for protocol in ('tls', 'tcp'):
            stranger = Shell(machines[1], env, tmp_path / f'stranger-{protocol}')
            stranger.type(f'export ZENOH_CONFIG_OVERRIDE=\'connect/endpoints=["{protocol}/{where[1]}"]\'')
            _sees_nothing(stranger)
        # With a keystore of its own, in which it names itself as the laptop is named.
        stranger.type('goalwire secure init keys')
        stranger.type('goalwire secure add laptop --person --role operator -k keys')
        stranger.type('goalwire secure add robot --robot -k keys')
        for line in ON_THE_LAPTOP.splitlines()[1:3]:
            stranger.type(line)
        _sees_nothing(stranger)
        assert 'sum=5' in laptop.type(CALL)


def _sees_nothing(stranger: Shell) -> None:
    with stranger.start(LIST) as looking:
        looking.wait()
        assert '/add_two_ints_server' not in looking.output
    with stranger.start(f'{CALL} --timeout 1') as calling:
        assert calling.wait() != 0
        assert 'sum=' not in calling.output
