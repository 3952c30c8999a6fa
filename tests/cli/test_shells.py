"""Completion as people meet it: a shell on a terminal, a word begun, and the tabulator."""

from __future__ import annotations

import shutil
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import pytest
from helpers.command_line import executable
from helpers.processes import Program

if sys.platform == 'win32':
    pytest.skip('shells of POSIX', allow_module_level=True)

from helpers.screens import Screen, screen

SHELLS = {
    'bash': (['--norc', '--noprofile', '-i'], 'eval "$(ros2 completion bash)"'),
    'zsh': (['-f', '-i'], 'eval "$(ros2 completion zsh)"'),
    'fish': (['--no-config', '-i'], 'ros2 completion fish | source'),
}
CASES = [
    ('ros2 interf', 'ros2 interface'),
    ('ros2 service ca', 'ros2 service call'),
    ('ros2 service call --retr', 'ros2 service call --retry'),
    ('goalwire service call /lab/ad', 'goalwire service call /lab/add'),
    ('ros2 service call /lab/add exam', 'ros2 service call /lab/add example_interfaces/srv/AddTwoInts'),
    ('ros2 action send_goal /lab/fib', 'ros2 action send_goal /lab/fibonacci'),
    ('ros2 interface show std_srvs/srv/SetB', 'ros2 interface show std_srvs/srv/SetBool'),
]

pytestmark = [pytest.mark.slow, pytest.mark.timeout(180)]


@pytest.fixture(scope='module', params=['rmw_zenoh_cpp'])
def world(request: pytest.FixtureRequest) -> dict[str, str]:
    """The wires are tried without a shell."""
    from helpers.isolation import isolated_env

    return isolated_env(request.param)


@contextmanager
def prompt(shell: str, env: dict[str, str], home: Path) -> Iterator[Screen]:
    """A shell that has read the completion, waiting for a command."""
    path = shutil.which(shell)
    if path is None:
        pytest.skip(f'there is no {shell} here')
    options, read = SHELLS[shell]
    env = env | {
        'PATH': f'{executable().parent}:{env["PATH"]}',
        'HOME': str(home),
        'XDG_CONFIG_HOME': str(home),
        'XDG_DATA_HOME': str(home),
        'PS1': '> ',
        'ZDOTDIR': str(home),
    }
    with screen(env, *options, program=path, size=(120, 24)) as shown:
        shown.sees('[>#$] *')
        shown.press(f'{read}; echo re""ady\r'.encode())
        shown.sees('(?m)^ready')
        yield shown


@pytest.mark.parametrize('shell', SHELLS)
def test_the_tabulator_completes_from_parsers_and_graph(
    shell: str, world: dict[str, str], workshop: Program, tmp_path: Path
) -> None:
    with prompt(shell, world, tmp_path) as shown:
        for begun, whole in CASES:
            shown.press(begun.encode())
            shown.sees(f'{begun}')
            shown.press(b'\t')
            shown.sees(rf'{whole}(?!\S)')
            shown.press(b'\x15')  # Ctrl-U: the line is emptied
            shown.misses(whole)


@pytest.mark.parametrize('shell', SHELLS)
def test_more_than_one_is_listed(
    shell: str, world: dict[str, str], workshop: Program, tmp_path: Path
) -> None:
    with prompt(shell, world, tmp_path) as shown:
        shown.press(b'ros2 service ')
        shown.sees('ros2 service')
        shown.press(b'\t\t')
        shown.sees(r'call\s+echo\s+find\s+info\s+list\s+type')
