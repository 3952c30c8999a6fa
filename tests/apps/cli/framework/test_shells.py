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

PROGRAMS = Path(__file__).parents[1] / 'programs'
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
    ('ros2 service call lab/ad', 'ros2 service call /lab/add'),
    ('ros2 topic pub /p std_msgs/msg/String da', 'ros2 topic pub /p std_msgs/msg/String data='),
]
HOSTILE = (
    '`>PWNED`', ';>PWNED;', '|tee PWNED', '>PWNED', "'>PWNED'", '">PWNED"', '\\`>PWNED`', ' x>PWNED',
    '&&>PWNED', '\n>PWNED\n', '\x1b]0;PWNED\x07', '\u202e`>PWNED`',
)  # fmt: skip
"""Names that a shell runs, or takes apart. Zenoh's keys have no '$', so `$(...)` cannot come this way."""

pytestmark = [pytest.mark.slow, pytest.mark.timeout(400)]


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


@pytest.fixture(scope='module')
def stranger(world: dict[str, str]) -> Iterator[Program]:
    """A peer that announces names which are commands to a shell."""
    with Program(PROGRAMS / 'hostile_names.py', *HOSTILE, env=world) as program:
        program.expect('^ready')
        yield program


@pytest.mark.parametrize('shell', SHELLS)
def test_no_name_of_a_stranger_is_run(
    shell: str, world: dict[str, str], workshop: Program, stranger: Program, tmp_path: Path
) -> None:
    """A word begun, the tabulator, Return: the line that results is run in a folder that stays empty.

    With --help a command looks for no topic: only what the shell does with the line is tried.
    """
    folder = tmp_path / 'here'
    folder.mkdir()
    lines = ['ros2 node info /node0_', 'ros2 topic echo --once --timeout 1 /typed0_ ']
    lines += [f'ros2 topic type --help /topic{at}_' for at in range(len(HOSTILE))]
    with prompt(shell, world, tmp_path) as shown:
        shown.press(f'cd {folder}; echo mo""ved\r'.encode())
        shown.sees('moved')
        for line in lines:
            shown.press(line.encode() + b'\t\r')
            shown.press(b'\x15echo do""ne\r')
            shown.sees('done')
            shown.press(b'clear\r')
            shown.misses('done')
    assert list(folder.iterdir()) == []


@pytest.mark.parametrize('shell', SHELLS)
def test_files_with_odd_names_are_one_word(
    shell: str, world: dict[str, str], workshop: Program, tmp_path: Path
) -> None:
    package = tmp_path / 'here' / 'odd_robot'
    (package / 'launch').mkdir(parents=True)
    (package / 'package.xml').write_text(
        '<package format="3"><name>odd_robot</name><version>0.0.0</version><description>x</description>'
        '<maintainer email="a@b.c">a</maintainer><license>MIT</license></package>'
    )
    (package / 'launch' / 'a b`>PWNED`;.launch.xml').write_text(
        '<launch><arg name="speed"/><log message="it is launched"/></launch>'
    )
    with prompt(shell, world, tmp_path) as shown:
        shown.press(f'cd {package.parent}; echo mo""ved\r'.encode())
        shown.sees('moved')
        shown.press(b'ros2 launch odd\t')
        shown.sees('odd_robot')
        shown.press(b'\t')
        shown.sees('PWNED')
        shown.press(b'sp\t')
        shown.sees('speed:=')
        shown.press(b'1; echo do""ne\r')
        shown.sees('it is launched')
        shown.sees('done')
    assert [each.name for each in package.parent.iterdir()] == ['odd_robot']


@pytest.mark.parametrize('shell', SHELLS)
def test_a_candidate_is_no_pattern_of_files(
    shell: str, world: dict[str, str], workshop: Program, tmp_path: Path
) -> None:
    """A launch file is called a*b, and a file beside its package matches that, quotes included."""
    package = tmp_path / 'here' / 'odd_robot'
    (package / 'launch').mkdir(parents=True)
    (package / 'package.xml').write_text(
        '<package format="3"><name>odd_robot</name><version>0.0.0</version><description>x</description>'
        '<maintainer email="a@b.c">a</maintainer><license>MIT</license></package>'
    )
    (package / 'launch' / 'a*b.launch.xml').write_text('<launch><log message="it is launched"/></launch>')
    trap = package.parent / "'a'; echo 1 > PWNED; 'b.launch.xml'"
    trap.touch()
    with prompt(shell, world, tmp_path) as shown:
        shown.press(f'cd {package.parent}; echo mo""ved\r'.encode())
        shown.sees('moved')
        shown.press(b'ros2 launch odd_robot \t')
        shown.sees(r'launch\.xml')
        shown.press(b'; echo do""ne\r')
        shown.sees('done')
        shown.sees('it is launched')
    assert sorted(each.name for each in package.parent.iterdir()) == [trap.name, 'odd_robot']
